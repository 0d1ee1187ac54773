"""German for what commands refuse, by code: problems of errors, and their remedies."""

ERRORS = {
    "column_missing": "Die Spalte {column} fehlt",
    "add_or_map": "vorhanden sind {there}: sie ergänzen, oder ihren Namen in [recording.columns] der Maschine zuordnen",
    "struts_and_drives": "enthält Strebenlängen und Antriebspositionen",
    "take_one_out": "eine davon aus [recording.columns] nehmen",
    "drives_alone": "enthält Antriebspositionen",
    "say_how_drives": "in [recording.drives] der Maschine sagen, wie sie die Streben bewegen",
    "blank_lines": "ist leer, hat nur Leerzeilen",
    "record_again": "neu aufzeichnen",
    "damaged_utf16": "ist beschädigter Text in UTF-16",
    "save_utf8": "noch einmal speichern, als UTF-8",
    "gzip_cut": "ist eine abgeschnittene gzip-Datei",
    "copy_again": "noch einmal kopieren",
    "gzip_damaged": "ist eine beschädigte gzip-Datei",
    "linuxcnc_lost": "LinuxCNC hat hier Abtastungen verloren und sagt nicht, wie viele",
    "longer_queue": "mit halsampler -t und einer längeren Warteschlange (Tiefe des sampler) aufzeichnen",
    "triggers_no_clocks": "haben je einen Trigger, aber nicht beide eine Uhr",
    "state_period": "recording.clock.period_ms angeben",
    "starts_after": "beginnt {seconds} s, nachdem {other} endet",
    "one_run_or_offset": (
        "die Dateien eines Laufs geben, oder in recording.clock.offset_s sagen, wie ihre Uhren sich unterscheiden"
    ),
    "numbers_for_names": "enthält Zahlen, wo Namen stehen sollten",
    "list_names": "die Namen in recording.column_names auflisten, wie hexcite look es tut",
    "not_text": "ist kein Text in UTF-8, UTF-16 mit Kennung oder cp1252",
    "save_or_export": "Text in anderer Kodierung als UTF-8 speichern; andere Dateien als CSV oder Parquet exportieren",
    "lvm_other_channels": "nennt andere Kanäle als der Abschnitt darüber",
    "lvm_segments": "jeden Abschnitt als eigene Datei geben",
    "no_rows": "hat Spalten, aber keine Zeilen",
    "no_messages": "enthält keine Nachrichten {kind}; ihre Topics sind {topics}",
    "record_topic": "auch ein solches Topic aufzeichnen",
    "rosbags_needed": "ist ein ROS-Bag, den rosbags liest",
    "install_ros": "pip install 'hexcite[ros]'",
    "bag_damaged": "ist ein beschädigter Bag ({reason})",
    "copy_or_reindex": "noch einmal kopieren, oder ros2 bag reindex ausführen",
    "copy_or_recover": "noch einmal kopieren, oder mcap recover DATEI -o GANZ.mcap ausführen",
    "copy_or_reindex_ros1": "noch einmal kopieren, oder rosbag reindex ausführen",
    "empty_bag": "enthält keine Nachricht",
    "not_scope": (
        "hat keine zwei Zeilen, die mit Name und einem Trennzeichen beginnen, und darunter Zeilen aus Zahlen, wie"
        " Exporte von TwinCAT Scope"
    ),
    "export_scope": "als CSV mit Kopf exportieren, oder recording.format in der Maschine angeben",
    "trace_no_records": "hat Signale, aber keine Werte",
    "trace_again": "den Trace noch einmal mit seinen Messwerten speichern",
    "trace_damaged": "ist beschädigtes XML ({cause})",
    "trace_save_again": "den Trace noch einmal speichern",
    "parquet_damaged": "ist eine beschädigte Parquet-Datei ({reason})",
    "copy_or_export": "noch einmal kopieren oder exportieren",
    "parquet_kind": "enthält {kind}, keine Zahlen",
    "export_double": "als double exportieren",
    "parquet_no_value": "hat in Zeile {row} keinen Wert",
    "not_this_text": "ist kein Text in {encoding}",
    "save_file_utf8": "die Datei als UTF-8 speichern",
    "clock_gap": "eine Uhr hat keinen Wert, geht aber darunter weiter",
    "again_with_times": "neu aufzeichnen oder exportieren, mit der Zeit jeder Zeile",
    "mend_row_or_period": "die Zeile berichtigen oder entfernen, oder recording.clock.period_ms angeben",
    "correct_clock": "recording.clock in der Maschine berichtigen",
    "export_csv": "als CSV exportieren, mit Komma oder Semikolon zwischen den Feldern",
    "export_semicolons": "mit Semikolons zwischen den Feldern exportieren, oder mit Dezimalpunkten",
    "lvm_header": "noch einmal mit mindestens einem Kopf schreiben",
    "header_longer": "hat {count} Zeilen, nicht mehr als recording.header_rows = {rows}",
    "no_header_names": "recording.header_rows = 0 lässt keine Namen",
    "list_them": "sie in recording.column_names auflisten",
    "not_a_number": "{value} ist keine Zahl",
    "cut_or_uncompressed": "den Lauf kürzen, oder ihn unkomprimiert als UTF-8 speichern",
    "line_too_long": "ist länger als eine Million Zeichen",
    "not_csv": "keine Tabelle in CSV",
    "leave_a_trigger": "einen der Trigger weglassen",
    "files_of_one_run": "Dateien eines Laufs geben, gemeinsam aufgezeichnet",
    "empty_file": "ist leer",
    "too_large_run": (
        "{count} Zahlen in diesem Lauf brauchen zum Auswerten mehr als die Hälfte des freien Speichers ({size} GB)"
    ),
    "cut_run": "den Lauf kürzen: höchstens {rows} Zeilen mit {columns} Spalten passen; oder Speicher freimachen",
    "one_row": "hat eine Zeile, das ist keine Bewegung",
    "no_numbers": "enthält keine Spalten aus Zahlen",
    "export_rows": "noch einmal exportieren, eine Zeile je Abtastung",
    "header_only": "hat einen Kopf, aber keine Zeilen",
    "record_or_export": "noch einmal aufzeichnen oder exportieren",
    "no_stamp": "ist leer, wo ein Zeitstempel nötig ist",
    "remove_row": "die Zeile entfernen",
    "binary_zero": "besteht aus Nullbytes, wie nach einem Absturz beim Aufzeichnen",
    "cut_file_there": "die Datei dort abschneiden",
    "other_width": "{expected} Spalten erwartet, {got} gefunden",
    "not_a_switch": "{value} ist kein Pegel eines Schalters",
    "forces_apart": "ihre Kräfte überdecken weniger als 3 Abtastungen der Bewegung",
    "record_together": "gemeinsam aufzeichnen",
    "clock_and_matrices": "hat eine Uhr und Drehmatrizen",
    "moving_from_drives": (
        "bewegte Läufe werden nur aus Antrieben ausgewertet; t_s entfernen, wenn jede Zeile ein gemittelter "
        "Stillstand ist"
    ),
    "few_behind_filter": (
        "{count} Abtastungen in Bewegung sind hinter einem Filter von {cutoff} Hz nur {independent} unabhängige"
    ),
    "record_longer": "länger aufzeichnen",
    "filter_needed": "ein bewegter Lauf braucht ein Filter",
    "state_cutoff": "recording.filter_cutoff_Hz in der Maschine angeben",
    "not_a_run": "{count} Abtastung ist kein Lauf",
    "too_much_damage": (
        "Schäden, mit der Reichweite des Filters von {reach} s auf jeder Seite, kosten {share} % der Bewegung, "
        "höchstens {most} % dürfen fehlen"
    ),
    "position_needed": "Modell {model} braucht die Position der Plattform, die Aufzeichnung hat nur Orientierungen",
    "other_model_or_drives": "Modell 0 oder 6 wählen, oder die Antriebe (Streben, Gelenke) aufzeichnen",
    "trigger_never": "ist nie 1",
    "trigger_or_none": "mit dem Trigger aufzeichnen, der während der Bewegung an ist, oder ihn weglassen",
    "cutoff_too_high": "filter_cutoff_Hz = {cutoff} ist zu hoch für {rate} Abtastungen je Sekunde",
    "at_most": "höchstens {most}{other}",
    "pose_constant": (
        "Die Pose ist konstant ({drives} bewegen sich um {travel} {unit}, mindestens {least} {unit_2} sind nötig)"
    ),
    "record_excitation": "die Anregung aufzeichnen, oder t_s aus gemittelten Stillständen entfernen",
    "drives_held": "Positionen der Antriebe stehen je {rows} Zeilen lang, und eine Lücke stört ihren Takt",
    "cut_or_apart": "den Lauf dort teilen, oder Antriebe und Kräfte als eigene Dateien exportieren",
    "mostly_damaged": "{share} % der Abtastungen sind unbrauchbar, höchstens {most} % dürfen es sein: {damage}",
    "mend_sensor": (
        "den Sensor in Ordnung bringen und neu aufzeichnen, oder die Maschine nennen, die aufgezeichnet wurde"
    ),
    "kept_unit": "recording.units.forces der Maschine sagt {kept}; damit sind {share} % der Werte unbrauchbar: Kräfte "
    "bis {largest} N, der Bereich ist {most} N",
    "unit_in_range": "keine Bezeichnung nennt eine Einheit, und in {unit} liegen die Kräfte im Bereich",
    "unit_of_labels": "die Einheit ist die der Bezeichnungen",
    "mass_of_forces_unit": "die Kräfte sind in {unit}",
    "negative_mass": "Die Masse ergibt sich zu {mass} ± {std} kg",
    "check_signs": "Vorzeichen der Kräfte, sensor_frame.transducer.sense und gravity_m_s2 der Maschine prüfen",
    "no_delay": "Keine Verzögerung bis {most} ms bringt Kräfte und Bewegung zusammen",
    "record_one_clock": "in einem Lauf mit einer Uhr aufzeichnen",
    "few_standstills": "{count} Stillstände von mindestens {least} s",
    "record_poses": "ein Programm von hexcite poses aufzeichnen, oder den Lauf als Bewegung auswerten",
    "moves_in_standstill": "Die Maschine bewegt sich, während der Trigger an ist (Stillstand {number})",
    "not_at_poses": "das ist keine Messung an Posen; als Bewegung auswerten",
    "short_standstill": (
        "Der Stillstand, der hier beginnt, hat {count} Abtastungen mit allen Werten, {needed} sind nötig"
    ),
    "accelerometer_needed": (
        "Ein bewegter Lauf ohne Positionen der Antriebe braucht Drehmatrizen und einen Beschleunigungssensor"
    ),
    "add_file": "die Datei ergänzen, die sie hat, oder t_s entfernen, wenn jede Zeile ein gemittelter Stillstand ist",
    "does_not_turn": "Der Sensor dreht sich nicht",
    "record_motion": "eine Bewegung aufzeichnen, oder t_s aus gemittelten Stillständen entfernen",
    "short_overlap": "Die Aufzeichnungen überdecken sich hinter dem Filter zu kurz",
    "few_stamps": "hat zu wenige Abtastungen mit Zeitstempel für einen bewegten Lauf",
    "few_for_filter": (
        "{count} Abtastungen sind zu wenige für ein Filter von {cutoff} Hz, das mehr als {needed} braucht"
    ),
    "longer_or_cutoff": "länger aufzeichnen, oder filter_cutoff_Hz erhöhen",
    "few_forces": "{samples} Abtastungen geben {forces} Kräfte für {unknowns} Unbekannte",
    "more_or_smaller": "mehr aufzeichnen, oder ein Modell mit weniger Parametern wählen",
    "not_determined": "Rang {rank} von {count}: {names} durch diesen Lauf nicht bestimmt",
    "excite_them": "sie anregen (eine Bewegung oder mehr Posen planen), oder ein Modell ohne sie wählen",
    "few_independent": "{rows} Kräfte, davon {independent} unabhängig, für {unknowns} Unbekannte",
    "forces_constant": "{name} ist nicht bestimmt: Die Kräfte ändern sich nicht",
    "check_channels": "die Kanäle prüfen",
    "channel_stuck": "Kanal {number} zeigt {value} bei jeder Abtastung",
    "check_cable": "sein Kabel und seinen Verstärker prüfen",
    "contact": "Die Kräfte verlassen das Modell in {share} % der Abtastungen, wie bei Kontakt ({where})",
    "free_run": (
        "Ein Lauf zum Bestimmen muss frei sein: Spalten, Antriebe, Modell (6 bis 9 in Bewegung) und Maße der "
        "Maschine prüfen, oder neu aufzeichnen"
    ),
    "forces_in_unit": (
        "Die Masse ergibt sich zu {mass} kg, wo nominal.mass_kg {nominal} nennt: Die Kräfte sind wohl in {unit}"
    ),
    "known_of_model": "{result} hat die Parameter von Modell {model}, der Plan die von Modell {number}",
    "plan_with_model": "mit {option} {model} planen, oder mit {option} {number} auswerten",
    "known_beforehand": "wurde mit bekanntem {name} ausgewertet, das nicht aus seinem Lauf folgt",
    "identify_without": "ohne {fix}, {drop} und {prior} auswerten",
    "other_payload_mounted": "{mounted} kg Nutzlast waren montiert, für {planned} kg wird geplant",
    "plan_with_payload": "mit {option} jenes Laufs planen",
    "known_of_motion": "ist von einer Bewegung, geplant sind Stillstände",
    "known_of_standstills": "ist von Stillständen, geplant ist eine Bewegung",
    "same_kind_of_run": "Ergebnisse von Läufen derselben Art nennen",
    "target_is_reached": "ist schon erreicht, durch {results}: {deviations}",
    "no_motion_needed": "keine Bewegung ist nötig",
    "box_excites_too_little": "Maschine {case}, limits.motion: für jede Bewegung in diesem Bereich {why}: Die Maschine "
    "dreht oder beschleunigt ihre Last nicht um genug Achsen",
    "wider_or_smaller_model": "den Bereich weiter machen, oder ein kleineres Modell als {number} wählen",
    "results_of_two_cases": "ist von Maschine {case}, {other} von {other_case}",
    "differs_from_first": "{what} ist {here}, bei {source} {there}",
    "none_stated": "keine",
    "identify_both_alike": "beide mit derselben Maschine und denselben Optionen auswerten",
    "also_with": "{again}, und mit {option}",
    "payload_open": "{missing} der Nutzlast nicht bestimmt, so dass sie weder in einem anderen Koordinatensystem noch "
    "als Last angegeben werden kann",
    "weigh_it_turned": "sie auch in einer anderen Orientierung wiegen",
    "not_a_robot": "ist nicht der eines Roboters: {purpose} ist für Aufbau R, einen Kraft-Momenten-Sensor am Flansch",
    "export_to_others": "mit {option} c, linuxcnc, st oder json exportieren",
    "flange_missing": "fehlt",
    "state_flange": "{purpose} zählt vom Flansch des Roboters aus: angeben, wo er in {of} liegt, etwa "
    "flange = {{ origin_mm = [0.0, 0.0, {z}] }}",
    "last_joints_frame": "dem bewegten Koordinatensystem des letzten Gelenks, wie machine.chain.sensor für {{P}}",
    "for_own_controller": "die eigene Steuerung der Maschine wählen, {others}, oder ",
    "settings_missing": "fehlt",
    "add_settings": "der Dialekt {dialect} braucht sie: {for_case}die Tabelle in der Maschine ergänzen, siehe "
    "cases/{example}/case.toml",
    "broken_periods": "die Dauer {duration} s ist keine ganze Zahl von Perioden von {period} s",
    "choose_duration": "{duration} s wählen",
    "no_period_fits": "keine Periode passt: {duration} s sind zu kurz, oder das Filter der Auswertung ist zu niedrig",
    "longer_duration": "{duration} größer wählen, oder {period} vorgeben",
    "short_period": "die Periode {period} s ist zu kurz: Ordnung {order} erreicht {frequency} Hz, die Auswertung lässt "
    "bis {limit} Hz durch (die Hälfte von recording.filter_cutoff_Hz)",
    "choose_or_more": "{option} {least} oder mehr wählen",
    "short_for_moves": "die Dauer {duration} s ist zu kurz für {count} Bewegungen: wegen controller.cycle_ms und der "
    "Grenzen des Rucks dauert jede {least} s",
    "fewer_moves": "weniger {option} ({fewest} oder mehr)",
    "no_pose_inside": "keine Pose liegt in poses.radius_mm und im XY-Bereich",
    "widen_one": "eines davon weiter machen",
    "no_pose_valid": "von {count} Posen ist keine möglich: {worst}, überschritten bei {share} % von ihnen",
    "or_narrow": "{remedy}, oder {what} enger machen",
    "poses_lose_rank": "{count} Posen bestimmen Modell {model} nicht: Algorithmus 1 endet bei {fewest}, jede weitere "
    "weniger verliert Rang",
    "ask_for_more": "{count} oder mehr verlangen",
    "set_forces_unit": "{key} = '{unit}' in die Maschine schreiben",
    "averaged_already": "Ihre Zeilen sind schon gemittelt",
    "leave_poses_out": "{poses} und {standstills} weglassen",
    "inertia_at_rest": "Modell {model} enthält Trägheit, die Stillstände nicht anregen",
    "model_to_5": "ein Modell von 0 bis 5 wählen, oder eine Bewegung aufzeichnen",
    "sense_missing": "fehlt",
    "state_sense": (
        "„load_on_sensor“ angeben, wenn ein hängendes Werkzeug von 1 kg -9,81 N entlang der Achse zeigt, die nach"
        " oben weist, sonst „sensor_on_load“"
    ),
    "no_case_name": "ist kein Name einer Maschine",
    "use_small_letters": "Kleinbuchstaben, Ziffern und Unterstriche verwenden, ein Buchstabe zuerst",
    "built_in_name": "ist der Name einer eingebauten Maschine",
    "choose_another": "einen anderen wählen",
    "case_exists": "gibt es schon",
    "folder_or_edit": "einen anderen Ordner wählen{output}, oder diese Datei bearbeiten",
    "stands_there": "Dort steht {what}",
    "place_or_overwrite": "einen anderen Ort wählen{output}, oder es mit {overwrite} ersetzen",
    "disk_full": "kann nicht geschrieben werden (dort sind {left} MB frei)",
    "make_room": "dort Platz schaffen",
    "not_writable": "kann nicht geschrieben werden ({reason})",
    "another_place": "einen anderen Ort wählen{output}",
    "duration_not_positive": "Die Dauer {duration} s ist nicht positiv",
    "choose_12": "etwa 12 s wählen",
    "short_for_spline": "Die Dauer {duration} s ist zu kurz für einen glatten Weg",
    "choose_at_least": "mindestens {least} s wählen",
    "jerk_not_limited": (
        "limits.motion der Maschine {case} nennt einen Ruck, den {controller}{named} nicht begrenzt: Kein "
        "Programm kann ihn dort einhalten"
    ),
    "without_jerk": (
        "mit {without} jerk planen, wenn die Maschine Sprünge der Beschleunigung verträgt, oder mit {to} virtual:"
        " Diese Bewegung hält ihn auf Steuerungen ein, die den Ruck begrenzen"
    ),
    "duration_too_long": "Die Dauer {duration} s ist mehr als {longest} s",
    "no_search_time": "{seconds} s ist keine Zeit zum Suchen",
    "choose_up_to": "{seconds} bis {longest} wählen",
    "target_not_understood": "ist nicht verständlich",
    "write_so": "{option} {example} schreiben",
    "not_a_parameter": "{name} ist kein Parameter von Modell {model}",
    "few_candidates": "{count} Posen sind verlangt, nur {available} Kandidaten sind gültig",
    "fewer_or_more": (
        "weniger verlangen, in [poses] kleinere Schritte nehmen, oder mit {candidates} mehr Kandidaten ziehen"
    ),
    "poses_too_few": "{count} Posen geben {forces} Kräfte für {parameters} Parameter von Modell {model}",
    "ask_for": "{fewest} oder mehr verlangen, etwa {usual} für brauchbare Standardabweichungen",
    "no_motion": "keine zulässige Bewegung: {limit}",
    "or_home": "{remedy}, oder die Grundstellung verschieben",
    "no_start": (
        "Start {seed} fand keine Bewegung innerhalb der Grenzen, die alle Parameter von Modell {model} bestimmt"
    ),
    "target_missed": "die beste, von {duration} s, sagt {predicted} voraus, {times}-mal so viel wie verlangt",
    "home_unreachable": "Die Grundstellung ist unerreichbar oder am Rand des Erreichbaren",
    "move_home": "die Grundstellung verschieben",
    "no_paths": "{name} {why}",
    "plan_moves": "mit {family} planen",
    "urscript_moves": (
        "URScript-Programme bestehen aus Bewegungen von Ruhe zu Ruhe, denn was servoj aus einem Weg macht, lässt "
        "sich nicht beweisen"
    ),
    "carries_warning": "trägt eine Warnung{more}: {warning}",
    "payload_negative": "Die Masse der Nutzlast, {mass} kg, ist nicht positiv",
    "mass_negative": "Die Masse {mass} kg ist nicht positiv",
    "another_run": "aus einem anderen Lauf bestimmen",
    "no_motion_in_program": "enthält keine Bewegung",
    "right_file": "Ist das die richtige Datei?",
    "nothing_triggered": "nichts bewegt sich, während der Trigger an ist",
    "write_by_post": "mit hexcite post schreiben",
    "not_linuxcnc": "ist kein LinuxCNC-Programm ({dialect})",
    "run_virtual": "mit {on} virtual laufen lassen",
    "trigger_never_on": "Der Trigger ging nie an, während {controller} es ausführte",
    "report_this": "das melden",
    "proven_for_other": "ist für die Maschine {other} bewiesen, deren Maße oder Grenzen andere sind als die von {case}",
    "own_case": "die Maschine des Programms geben, oder den Plan für diese schreiben",
    "speed_outside": "Die Geschwindigkeit {speed} liegt außerhalb von {slowest} bis 1",
    "first_try": "0.1 für den ersten Versuch wählen",
    "offsets_alone": "hat nur Nullpunkte, keinen Körper, der in Achsen anzugeben wäre",
    "identify_moving": "einen bewegten Lauf auswerten",
    "same_recording": "ist von derselben Aufzeichnung wie {other}",
    "before_then_after": "das Ergebnis eines Laufs ohne die Nutzlast nennen, dann eines mit ihr",
    "no_payload": "Die Masse unterscheidet sich von {other} um {mass} ± {std} kg, nicht durch eine Nutzlast",
    "without_then_with": "die Ergebnisse ohne und mit Nutzlast nennen, in dieser Reihenfolge",
    "one_result": "{count} Ergebnis",
    "two_results": "zwei oder mehr Ergebnisse derselben Maschine und Last nennen",
    "each_once": "jeden Lauf einmal nennen",
    "counts_prior": "enthält ein Vorwissen über {name}, das ein Mittel noch einmal zählte",
    "without_prior": "ohne {prior} auswerten",
    "other_payload": "Montiert war eine Nutzlast von {mounted} kg, bei {source} eine von {first} kg",
    "same_load": "Läufe mit derselben Last zusammenfassen; hexcite payload vergleicht zwei Lasten",
    "other_kind": "ist von {kind}, {source} von {other}",
    "one_kind": "Läufe einer Art zusammenfassen",
    "one_sample": "{count} Abtastung",
    "tare_needs": "zum Tarieren braucht es einen Stillstand von zwei oder mehr",
    "moves_in_tare": "{drives} bewegen sich um {travel} {unit}, in einem Stillstand höchstens um {most} {unit_2}",
    "cut_motion": "die Bewegung abschneiden",
    "not_judged": "kann nicht beurteilt werden: {why}",
    "state_accept": "Grenzen in [accept] angeben",
    "no_result_there": "enthält kein Ergebnis",
    "name_results": "Ordner von hexcite identify nennen, oder was solche enthält",
    "result_changed": "wurde von Hand geändert",
    "plan_changed": "wurde von Hand geändert",
    "plan_again": "neu planen",
    "recording_changed": "wurde von Hand geändert",
    "case_changed": "Die Maschine {case} {differs}: {change}{more}",
    "known_of_other": "wurde mit einer anderen Maschine {case} bestimmt: {change}",
    "identify_with_plan": "die Aufzeichnung mit der Maschine des Plans neu auswerten",
    "ini_no_number": "[{section}]{key} = {text} ist keine Zahl",
    "ini_comment": "berichtigen; ein Kommentar braucht dort eine eigene Zeile",
    "linuxcnc_old": "LinuxCNC {version} hat hier keinen Planer mit begrenztem Ruck (s_curve, seit {since})",
    "on_virtual": "mit {on} virtual laufen lassen",
    "setup_1a": "ist 1a, ein Sensorsystem, das sich nicht bewegt; eines, das es tut, braucht: {purpose}",
    "tare_instead": "hexcite tare, hexcite force und hexcite identify mit payload für das nehmen, was daraufliegt",
    "payloads_are": "sind {count}",
    "mountable": "{payloads} lassen sich nicht montieren: 0 bis {most} wählen",
    "limit_falls": "{limit} fällt auf {worst} {unit}{at}, mindestens {bound} ist nötig",
    "limit_reaches": "{limit} erreicht {worst} {unit}{at}, erlaubt ist {bound}",
    "at_time": " bei {time} s",
    "accelerates_as_hard": "keine zulässige Bewegung: {limit}, denn die Steuerung beschleunigt in jeder Bewegung so "
    "stark, wie sie eingestellt ist",
    "lower_or_path": "die Beschleunigungen in limits.motion und in der Steuerung senken, länger suchen oder eine Bahn "
    "planen (Spline, Fourier-Reihe)",
    "smaller_box": "diesen Kasten in {table}.keep_out verkleinern",
    "narrow_joints": (
        "position_deg in {joints} enger angeben, die Körper in machine.chain berichtigen oder in may_touch nennen"
    ),
    "correct_weights": "{effort} oder link in machine.chain.joints, oder nominal berichtigen,",
    "lower_accelerations": "die Beschleunigungen in {joints} senken, {effort} oder nominal berichtigen",
    "less_weight": "Gewichte aus [payloads] nehmen, sensors.range_N oder range_Nm berichtigen",
    "narrow_poses": "die Posen in {box} enger angeben",
    "widen": "{key} weiter angeben",
    "changed_since": "hat sich seither geändert",
    "differs_from": "ist eine andere als {origin}",
    "restore_case": "die Maschine wiederherstellen",
    "name_own_case": "ihre eigene Maschine mit {case} nennen",
    "at_own_risk": "auf eigene Gefahr mit {stale} weitermachen",
    "run_again": "das Programm noch einmal laufen lassen",
    "identify_again": "die Parameter noch einmal bestimmen",
    "was_is": "{name} war {before}, ist {now}",
    "something_changed": "etwas (mehr als ein Fingerabdruck steht nicht darin)",
    "not_stated": "nicht angegeben",
    "more_of_them": " ({count} weitere)",
    "none_of_columns": (
        "keine der Spalten {columns}; vorhanden sind {there}: sie so nennen oder in [recording.columns] zuordnen,"
        " oder Trennzeichen und Kopf in [recording] der Maschine angeben, wie hexcite look es vorschlägt"
    ),
    "no_forces": "keine Kräfte: {none}",
    "no_pose": "keine Pose: {none}",
    "likewise": " (ebenso {count} weitere)",
    "state_unit": "recording.units.{role} angeben, eines von {units}; oder {scale}",
    "scale_of": "recording.scale = {{ {ours} = .. }}: was eine 1 jedes Kanals in {usual} ist",
    "unknown_unit": "{text} ist keine bekannte Einheit für {role}{others}",
    "in_its_table": "Schlüssel dieser Datei stehen in recording.files[{number}] der Maschine",
    "no_unit_beside": "nennt keine Einheit{others}, während {label} {text} nennt",
    "state_unit_of_all": (
        "recording.units.{role} = '{unit}' angeben, wenn alle {role} in {unit} sind; sonst recording.scale = {{ {keys}"
        " }}: was eine 1 jedes Kanals in {usual} ist"
    ),
    "several_units": "nennt verschiedene Einheiten, {text}{others}",
    "counts": "enthält Zählwerte ({text}), die nur durch einen Faktor eine Einheit haben{others}",
    "state_scale": "{scale} angeben; sind sie schon {role}, recording.units.{role} = '{usual}'",
    "shares": "enthält Anteile eines Bereichs ({text}), die nur durch diesen Bereich eine Einheit haben{others}",
    "over_100": "den Bereich jedes Sensors durch 100 (durch 1, wo Zahlen bis 1 reichen)",
    "range_of_sensors": "wenn 100 % der Bereich in [sensors] ist; sonst den Bereich des Rekorders durch 100",
    "state_range": "{keys} angeben, {range}",
    "and_more": "{remedy} ({more} weitere: {all} zeigt sie)",
    "slow_down": "langsamer fahren, oder die Bewegung ändern",
    "change_move": "die Bewegung ändern",
    "exceeded_as_predicted": "nach der Vorhersage ÜBERSCHRITTEN: {limits}",
    "none_exceeded": "nach der Vorhersage wird keine überschritten",
    "nobody_enforces": "{controller} erzwingt {limits} in dieser Bewegung nicht, und nichts sonst tut es; {predicted}",
    "write_with": "mit {accept} schreiben, wenn die Maschine es verträgt",
    "plan_without_jerk": (
        "Bewegungen dafür mit {family} {made_for}{without} jerk planen (Posen mit {without} jerk), oder dieses mit "
        "{accept} schreiben, wenn die Maschine es verträgt"
    ),
    "noise_not_judged": "Rauschen: {why}",
    "no_mass_in_model": "Masse: Das Modell hat keine",
    "no_nominal_mass": "Masse: [nominal] nennt keine",
    "payload_was_mounted": "Masse: Es war eine Nutzlast montiert, [nominal] ist die Maschine ohne sie",
    "no_plan_beside": "der Lauf neben seinem Plan: mit dem Plan auswerten",
    "path_error_unknown": "Bahnfehler: Die Aufzeichnung nennt ihn nicht",
    "no_such_deviation": "deviations.{key}: Das Modell hat keinen solchen Parameter",
    "reference_unknown": "Vergleichswert für {name}: ist hier nicht bestimmt",
    "noise_not_kept": "bestimmt, bevor Ergebnisse es enthielten",
    "noise_not_stated": "sensors.force_noise_N nennt keines",
    "noise_of_a_run_not_kept": "ein Lauf des Mittels wurde bestimmt, bevor Ergebnisse es enthielten",
    "and_more_listed": "{remedy} ({more} weitere, wie aufgelistet)",
    "trigger_off_in_motion": "der Trigger ist {on} s lang ohne die Bewegung an, in Impulsen oder als Schalter, der in "
    "Bewegung aus ist: die Bewegung wird ohne ihn ausgewertet",
}
"""Problems and remedies."""

READERS = {
    "period_not_used": "{file}: recording.clock.period_ms wird nicht benutzt, die Uhren haben ihre Stempel",
    "period_counts_apart": (
        "{file}: recording.clock.period_ms = {period} zählt, nicht die Zeitstempel, die im Mittel {apart} ms "
        "auseinanderliegen"
    ),
    "rows_repeat": "{file}: {count} Zeilen wiederholen die darüber, zuerst {first}; weggelassen",
    "row_repeats": "{file}: 1 Zeile wiederholt die darüber, {first}; weggelassen",
    "period_counts": (
        "{file}: recording.clock.period_ms = {period} zählt, nicht die Zeitstempel; diese sagen, welche "
        "Abtastungen verloren gingen"
    ),
    "period_contradicts": (
        "{file}: recording.clock.period_ms = {period} zählt, nicht die Zeitstempel, die {apart} ms "
        "auseinanderliegen: Beschleunigungen unterscheiden sich um {percent} %; klären, was stimmt"
    ),
    "taken_at_steps": "die Abtastungen gelten als zu diesen Zeiten genommen",
    "taken_at_stamps": "an den Stempeln ist die Bewegung glatter, darum wird zwischen ihnen interpoliert",
    "stamps_stray": (
        "{file}: Zeitstempel streuen um gleiche Schritte von {step} ms um {rms} ms (rms), höchstens {most} ms; {done}"
    ),
    "lost_unseen": ": einzelne verlorene Abtastungen sind hinter dieser Streuung nicht zu sehen",
    "step_uncertain": (
        "{file}: Der Schritt von {step} ms ist auf {percent} % unsicher{hidden}; recording.clock.period_ms "
        "angeben, wenn er bekannt ist"
    ),
    "edges": "{count} Flanken des Triggers",
    "one_edge": "1 Flanke des Triggers",
    "clocks_as_stated": "{pair}: {edges} stimmen mit recording.clock.offset_s auf {within} ms überein",
    "clocks_not_as_stated": (
        "Die Uhren von {pair} unterscheiden sich um {shift} s mehr, als recording.clock.offset_s sagt, nach "
        "{edges}; berichtigen oder weglassen"
    ),
    "one_clock": "{pair} haben eine Uhr: {edges} stimmen auf {within} ms überein",
    "clock_rate": ", Gang {rate} ± {std} ppm",
    "clock_rate_left_out": ", Gang {rate} ± {std} ppm, nicht signifikant und weggelassen",
    "ways_to_fit": "; die längste von {count} Arten, wie ihre Flanken passen",
    "clocks_joined": "Die Uhr von {file} ist mit der von {other} durch {edges} verbunden: {shift} s{rate}{ways}",
    "trigger_bit": "Der Trigger ist Bit {bit} von {column}, das sich als einziges ändert",
    "trigger_constant": "Der Trigger schaltet nie, er ist immer {level}: Er markiert nichts",
    "read_in_unit": "{role} werden in {unit} gelesen, wie die Datei von {columns} sagt, {file}",
    "at_full_range": "ist am Ende seines Bereichs von {most} {unit}",
    "stuck_in_motion": "steht bei {value}, während die Maschine sich bewegt",
    "jumps": "springt für einzelne Abtastungen um bis zu {most} {unit}",
    "drive_jumps": (
        "springt um bis zu {most} {unit} zwischen Abtastungen im Abstand von {step} ms, was die Grenze von {limit} "
        "verbietet"
    ),
    "a_channel": "Kanal",
    "a_strut": "Strebe",
    "a_joint": "Gelenk",
    "also_others": " (ebenso {thing} {others})",
    "damaged": "{thing} {number} {what}{also}; weggelassen",
    "lost_bridged": "{behind}; aus ihren Nachbarn überbrückt",
    "lost_gap": "{behind}; kein Filter reicht hinüber",
    "one_lost_behind": "hinter {places} fehlt 1 Abtastung",
    "lost_behind": "hinter {places} fehlen {count} Abtastungen",
    "and_others": " (und {count} weitere)",
    "strut_outside": (
        "Strebe {number} mit {length} mm{also} liegt außerhalb des Arbeitsraums von {low} bis {high} mm; "
        "Nullpunkt und Reihenfolge der Streben prüfen, oder workspace.strut_length_mm"
    ),
    "joint_outside": (
        "Gelenk {name} liegt mit {position} {unit}{also} jenseits seiner Enden von {low} bis {high} {unit}; "
        "Nullpunkte, Vorzeichen und Reihenfolge der Gelenke prüfen, oder {key}"
    ),
    "standstills_of_plan": "{count} von {all} Stillständen werden ausgewertet, die an den Posen des Plans",
}
"""Notes of those who read recordings: clocks, triggers, units."""
