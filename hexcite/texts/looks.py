"""German for what is said of files of unknown layout, by code."""

LOOKS = {
    "estimated_wrench": "äußere Kräfte, die {who} aus den Momenten der Gelenke schätzt",
    "sensor_on_flange": "einen Sensor am Flansch aufzeichnen",
    "wrench_of_tcp": "Kräfte, die die Steuerung von Universal Robots in die Achsen der Basis dreht, ohne die "
    "gesetzte Nutzlast, und die sie nullt",
    "record_ft_raw": "ft_raw_wrench aufzeichnen",
    "force_at_tool": "die Kraft am Werkzeug, die eine Steuerung berechnet",
    "record_own_channels": "die Kanäle des Sensors selbst aufzeichnen, etwa ft_raw_wrench",
    "computed_wrench": "dem Namen nach Kräfte, die aus Anzeigen berechnet wurden",
    "record_raw_channels": "die rohen Kanäle des Sensors selbst aufzeichnen",
    "may_be_several": "{columns} können {several} sein: in [recording.columns] nennen, welche es sind",
    "other_joint_count": "{columns} sehen aus wie Positionen von {count} Gelenken, die Maschine hat {own}",
    "joints_or_drives": "{columns} können Gelenke oder Antriebe sein; die Maschine nennen",
    "name_the_robot": "den Roboter nennen, für die Reihenfolge seiner Gelenke",
    "not_readings": "{columns}: keine Anzeigen des Sensors, sondern {what}; {remedy}",
    "rows_or_columns": "{columns}: die 16 Zahlen einer homogenen Matrix, zeilen- oder spaltenweise; r11 bis r33 in "
    "[recording.columns] zuordnen",
    "no_readings_by_name": "{columns} haben Einheiten von Kräften, sind nach {word} aber keine Anzeigen; sind sie es "
    "doch, sie in [recording.columns] nennen",
    "names_of_case": "die Maschine war für andere Dateien: recording.columns nennt {theirs}, was diese Datei nicht "
    "hat; der Vorschlag nimmt ihre eigenen Namen",
    "taken_for_clock": "{name} gilt als Uhr; auch {others} läuft weiter",
    "time_by_name": "{which}: dem Namen nach eine Zeit, aber keine Zahl, die mit den Zeilen weiterläuft",
    "counts_rows": "{name} zählt die Zeilen, das ist keine Zeit: recording.clock.period_ms angeben",
    "rises_evenly": "{name} steigt gleichmäßig wie eine Uhr: ist es eine, t_s = {name} in [recording.columns] "
    "schreiben, und ihre Einheit in recording.clock.unit ({units})",
    "each_may_be": "{names}: jede kann {ours} sein; eine davon in [recording.columns] als {ours} nennen",
    "taken_for_bit": "als Trigger gilt Bit {bit} von {column}, das sich als einziges ändert",
    "orientation_taken": "Orientierung gelesen als {name}: {words}",
    "orientation_or": "{sentence}; es kann auch {more} sein: vergleichen",
    "not_a_time_unit": "{name}: {text} ist keine Einheit der Zeit; nach ihren Schritten sind die Stempel in {unit}",
    "span_in": "{names} in {unit}",
    "units_guessed": "Einheiten nach den Werten vermutet: {each}; mit den Einstellungen des Rekorders vergleichen",
    "other_clock_unit": "{name}: Schritte von {step} {wrong} wären {slow} Zeilen je Sekunde; sie sind wohl in "
    "{unit}, das sind {rate} Zeilen je Sekunde: recording.clock.unit",
    "joints_far": "{names}: in {wrong} sind die Gelenke weit von der Grundstellung oder über ihren Enden, in {unit} "
    "nicht; sind sie in {unit}, recording.units.{role} = '{unit}' angeben",
    "label_over_kept": "{names}: die Datei sagt {unit}, {key} der Maschine, das von einer anderen Datei ist, sagt "
    "{kept}; vorgeschlagen wird {unit}",
    "kept_out_of_range": "{names}: in {kept}, das recording.units.forces von einer anderen Datei hat, liegen sie über "
    "dem Bereich von {most} N; keine Bezeichnung nennt eine Einheit, und {unit} passt: es wird vorgeschlagen",
    "kept_excluded": "{names}: in {kept}, das {key} von einer anderen Datei hat, können die Werte nicht sein; keine "
    "Bezeichnung nennt eine Einheit, und {unit} passt: es wird vorgeschlagen",
    "what_a_1_is": "was eine 1 von jedem in der Einheit unseres Namens ist",
    "range_over_100": "den Bereich jedes Sensors durch 100",
    "range_of_case": "den Bereich jedes Sensors durch 100, nach [sensors] der Maschine",
    "state_scales": "{names}: {what} angeben: {keys}",
    "period_left_out": "{name} hat Zeitstempel: recording.clock.period_ms der Maschine bleibt weg",
    "step_in_header": "keine Spalte ist eine Uhr; {text} im Kopf: recording.clock.period_ms",
    "other_rate_in_header": "{name} ergibt {rate} Zeilen je Sekunde, der Kopf sagt {text}: die Einheit der "
    "Zeitstempel prüfen, recording.clock.unit",
    "cutoff_of_case": "filter_cutoff_Hz = {cutoff} der Maschine lässt nichts von einer Bewegung; {rate} Zeilen je "
    "Sekunde tragen {usual}",
    "slow_rows": "; das lässt nichts von einer Anregung: schneller aufzeichnen, oder die Uhr berichtigen",
    "cutoff_carried": "filter_cutoff_Hz: {rate} Zeilen je Sekunde tragen höchstens ein Fünftel davon, {carried} Hz "
    "statt {cutoff} Hz{low}",
    "no_clock_there": "keine Uhr: jede Zeile gilt als gemittelter Stillstand; bei einer Bewegung "
    "recording.clock.period_ms angeben",
    "no_trigger_there": "kein Trigger: die ganze Bewegung wird ausgewertet, auch die Wege von und zur Grundstellung",
    "in_file": "{file}: {sentence}",
    "does_not_read": "[recording], wie es die Maschine hat, liest sie nicht: {why}",
    "no_name": "{name} hat keinen Namen: {what}",
    "name_all": "die Namen aller Spalten in recording.column_names auflisten, in ihrer Reihenfolge; nach Werten wird "
    "nichts vermutet",
    "few_numbers": "zu wenige Zahlen, um zu sagen, was es ist",
    "constant_value": "immer {value}, wie eine Konstante oder ein Schalter, der nie benutzt wird",
    "two_values": "{low} oder {high}, wie ein Schalter; ein Trigger vielleicht",
    "rises_as_rows": "steigt um {step} von Zeile zu Zeile, wie Nummern der Zeilen",
    "rises_as_clock": "steigt um {step} von Zeile zu Zeile, wie eine Uhr",
    "smooth_values": "{low} bis {high}, glatt wie eine Position, ein Winkel oder Sollwert",
    "noisy_values": "{low} bis {high}, mit Rauschen wie eine Kraft oder ein Moment",
    "has_forces_alone": "sie hat Kräfte und keine Pose; hat eine andere Datei des Laufs sie, beide nennen: {both}",
    "has_pose_alone": "sie hat eine Pose und keine Kräfte; hat eine andere Datei des Laufs sie, beide nennen: {both}",
    "not_read": "mit diesen Einstellungen nicht lesbar: {why}",
    "identify_refuses": "sie ist lesbar, aber es lässt sich daraus nichts bestimmen (Tarieren und Kräfte gehen "
    "vielleicht, als Stillstand): {why}",
    "deviation_parts": "die Abweichung von {name} hat Teile [{unit}]: {parts}",
    "part_of": "{kind} {size}",
}
"""What to compare or complete."""
