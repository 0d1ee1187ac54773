"""German for sentences that commands make of codes and values: causes, remedies and findings, by code."""

from hexcite.texts.cases import CASES
from hexcite.texts.effects import EFFECTS
from hexcite.texts.errors import ERRORS, READERS
from hexcite.texts.looks import LOOKS
from hexcite.texts.plans import PLANS
from hexcite.texts.reports import REPORTS

CAUSES = {
    "cause": "{words}: Dann sind die Residuen {smaller} ({newtons} N, wo Rauschen {noise} N macht); {remedies}",
    "small": "klein",
    "times_smaller": "{times}-mal kleiner",
    "write": "zu schreiben: {keys}",
    "one_key": "{key}{text}",
    "no_key": "kein {key}",
    "in_joint": "in Gelenk {name} von machine.chain.joints: {keys}",
    "in_table": "in [{table}]: {keys}",
    "too_loose": "zu ungenau bekannt, um in die Maschine geschrieben zu werden ({why}): an der Maschine messen und das "
    "schreiben",
    "would_be_off": "{name} läge um {off} {unit} daneben, wo {reported} {unit} angegeben würde",
    "explained": "{problem} ({tried})",
    "not_one": "nichts davon erklärt {left}: {tried}",
    "not_two": "nichts davon, auch nicht zwei zusammen, erklärt {left}: {tried}",
    "least_left": "{nothing}; am wenigsten bleibt, {newtons} N, mit: {words}",
    "residuals_of": "Residuen von {newtons} N, wo Rauschen {noise} N macht",
    "the_run": "den Lauf",
    "family_clock": "Uhren",
    "family_orientation": "Arten, Orientierungen zu schreiben",
    "family_units": "Einheiten",
    "family_channels": "vertauschte, verschobene und umgekehrte Kraftkanäle",
    "family_gains": "Maßstäbe einzelner Kanäle",
    "family_drives": "vertauschte und verschobene {drives}",
    "family_axes": "Kräfte und Momente in den Achsen der Basis",
    "family_point": "Momente um einen anderen Punkt",
    "family_compensated": "kompensierte Kräfte",
    "family_sensor": "ein verdrehter Sensor",
    "family_signs": "Vorzeichen der {drives}",
    "family_offsets": "Nullpunkte der {drives}",
    "family_gravity": "Schwerkraft",
    "family_machine": "Ringe, Gelenke und Grundstellung des Hexapods",
    "family_bars": "Ringe und Enden der Stäbe",
    "family_leaps": "ein springender Nullpunkt",
}
"""The cause of a run's residuals, or what was tried."""

CHANNELS = {
    "exchanged": "{what}: {pairs} vertauscht",
    "pair": "{one} und {other}",
    "shifted": "{what}: um {places} verschoben",
    "reordered": "{what} in anderer Reihenfolge: {cycle}",
    "in_place_of": "{one} steht an der Stelle von {other}",
    "force_channels": "Kraftkanäle",
    "forces_and_moments": "Kräfte und Momente",
    "struts": "Streben",
    "joints": "Gelenke",
    "positions": "Positionen",
    "quaternion": "Teile des Quaternions",
    "channel_signs": "Vorzeichen der Kraftkanäle {numbers} umgekehrt",
    "moments_in": "Momente in {unit}",
    "gain_small": "{name} ist {size} % kleiner, als die anderen Kanäle sagen",
    "gain_large": "{name} ist {size} % größer, als die anderen Kanäle sagen",
    "about_axis": "{angle} Grad um seine {axis}-Achse",
    "about": "{angle} Grad um ({along})",
    "sensor_turned": "Der Sensor ist verdreht, um {about}",
    "turn_it": "Kräfte und Momente im Rekorder drehen, um {about}",
    "moments_about": "Momente um einen Punkt ({place}) mm vom Ursprung des Sensors, in dessen Achsen",
    "record_about_origin": "Momente um den Ursprung des Sensors aufzeichnen",
    "compensated": "Die Kräfte sind kompensiert: Es fehlt das Gewicht dessen, was der Sensor trägt",
    "compensated_in_part": "Die Kräfte sind kompensiert: Es fehlen {share} % des Gewichts dessen, was der Sensor trägt",
    "record_raw": "roh aufzeichnen, jede Kompensation von Werkzeug oder Nutzlast ausgeschaltet",
    "in_base": "Kräfte und Momente stehen in den Achsen der Basis, nicht des Sensors",
    "record_in_sensor": "roh aufzeichnen, in den Achsen des Sensors selbst",
    "offsets_leap": "Nullpunkte springen: {parts},",
    "by": "{of} um {size} {unit}",
    "load_changes": "Die Last ändert sich um {size} kg",
    "at_about": "{what} bei etwa {line}{time}",
    "cut_there": "den Lauf dort teilen und die Teile einzeln auswerten, der längere ist {longer}",
    "before_line": "vor {line}",
    "from_line": "ab {line}",
}
"""Mistakes in recorded forces."""

MOTION = {
    "struts_in": "{role} in {unit}",
    "strut_signs": "Vorzeichen der Streben {which} umgekehrt",
    "alphabetic": "{words} (sie wurden in der Reihenfolge des Alphabets aufgezeichnet)",
    "joints_turning": "Drehgelenke",
    "joints_sliding": "Schubgelenke",
    "joints_in": "{every} in {unit}",
    "joints_turn_back": "Die Gelenke {names} drehen andersherum",
    "joints_move_back": "Die Gelenke {names} laufen andersherum",
    "joint_turns_back": "Gelenk {names} dreht andersherum",
    "joint_moves_back": "Gelenk {names} läuft andersherum",
    "joint_zero": "Gelenk {joint} steht bei {angle} Grad, wo es 0 anzeigt",
    "joints_leap": "Anzeigen der Gelenke {names} springen um 360 Grad",
    "joint_leaps": "Die Anzeige von Gelenk {names} springt um 360 Grad",
    "forces_late": "Kräfte sind {size} ms später gestempelt als die Bewegung",
    "forces_early": "Kräfte sind {size} ms früher gestempelt als die Bewegung",
    "stamps_in": "Zeitstempel in {unit}",
    "samples_apart": "Der Abstand der Abtastungen ist {apart} ms, nicht {stated} ms",
    "written_as": "Orientierungen sind als '{name}' geschrieben{users}",
    "angles_in": "Winkel der Pose in {unit}",
    "positions_in": "Positionen in {unit}",
    "sign_turned": "Vorzeichen von {name} umgekehrt",
}
"""Mistakes in the recorded motion and its clock."""

MACHINE = {
    "base_joints": "Gelenke der Basis",
    "platform_joints": "Gelenke der Plattform",
    "ring_joints": "Gelenke von Basis und Plattform",
    "lower_ends": "untere Enden der Stäbe",
    "upper_ends": "obere Enden der Stäbe",
    "bar_ends": "Enden der Stäbe",
    "rings_exchanged": "Basis und Plattform sind vertauscht",
    "home_below": "Die Grundstellung steht auf dem Kopf",
    "counted_from": "{what}: von einem anderen aus gezählt ({first} ist 1)",
    "half_angle_other_way": "{what}: Halbwinkel andersherum gemessen",
    "half_angle_full": "{what}: Der Halbwinkel ist der ganze Winkel",
    "half_angle_full_other_way": "{what}: Der Halbwinkel ist der ganze Winkel, andersherum gemessen",
    "half_angle_half": "{what}: Der Halbwinkel ist die Hälfte davon",
    "radius_full": "{what}: Der Radius ist ein Durchmesser",
    "radius_half": "{what}: Der Radius ist die Hälfte davon",
    "other_side": "{what}: auf der anderen Seite des Ursprungs, entlang z",
    "turned_60": "{what}: um 60 Grad verdreht",
    "turned_back_60": "{what}: um -60 Grad verdreht",
    "turned_180": "{what}: um 180 Grad verdreht",
    "radii_exchanged": "Radien vertauscht: {first}, {second}",
    "half_angles_exchanged": "Halbwinkel vertauscht: {first}, {second}",
    "radii_half_angles_exchanged": "Radien und Halbwinkel vertauscht: {first}, {second}",
    "heights_exchanged": "Höhen vertauscht: {first}, {second}",
    "bars_turned": "Die Stäbe sind um {angle} Grad um z verdreht",
    "on_a_slope": "Die Schwerkraft zeigt {away} Grad neben gravity_m_s2: Die Maschine steht schräg",
    "gravity_along": "Die Schwerkraft zeigt entlang {word} von {{B}}",
}
"""Mistakes in the drawing of the machine, and where it stands."""

PROGRAMS = {
    "override_faster": "Ein Vorschub-Override über 100 % macht es schneller, als bewiesen ist; {remedy}",
    "slowed_for_points": "{share} % langsamer als geplant: Mit der Geschwindigkeit des Plans würde {limit} durch seine "
    "Punkte {ratio} % der Grenze erreichen",
    "override_linuxcnc": "M50 P0 vor die erste Bewegung schreiben, oder den Knopf bei 100 % enden lassen "
    "(MAX_FEED_OVERRIDE = 1)",
    "override_sinumerik": "höchstens 100 % lassen, oder den Knopf dort enden lassen (MD12030)",
    "override_twincat": "höchstens 100 % lassen, oder ihn in der SPS dort enden lassen",
}
"""Remarks on programs."""

FINDINGS = {
    "noise_memory": "Das Rauschen ist nicht weiß: Die Abweichung von {name} ist {times}-mal so groß wie bei weißem "
    "Rauschen; ± enthält es",
    "explains_little": "Das Modell erklärt nur {share} % der Varianz der Kräfte; Reihenfolge, Vorzeichen und Einheit "
    "von Kräften und {drives} prüfen",
    "other_feed": "Der aufgezeichnete Override ist {low} bis {high} %: Die Parameter gelten, denn sie folgen aus der "
    "gemessenen Bewegung; die Zahlen des Plans gelten nicht für diesen Lauf: Beschleunigungen gehen mit dem Quadrat "
    "des Vorschubs",
    "large_delay": "Verzögerung von {delay} ms: Gehören die Aufzeichnungen zusammen?",
    "averaged": "Kräfte: {count} Abtastungen für jede der Bewegung gemittelt, zentriert: keine Laufzeit",
    "pose_errors": "[sensors] {settings}: Damit in der Maschine rechnen Pläne mit den Fehlern, die von der Pose "
    "abhängen",
    "moments_in_mm": "Der Schwerpunkt liegt {distance} m vom Ursprung der Plattform: Die Momente sind wohl in N mm; "
    "recording.units.moments = 'Nmm' in die Maschine schreiben",
    "other_mass": "Die Masse ergibt sich zu {mass} kg, wo nominal.mass_kg, mit Nutzlasten, {expected} kg nennt: "
    "nominal berichtigen, oder Schwerkraft, Einheiten, Montiertes prüfen, und ob Kräfte roh aufgezeichnet sind, "
    "nicht kompensiert",
    "impossible_body": "{words}; Vorzeichen und Reihenfolge der Kraft- und Momentenkanäle und die Maße der Maschine "
    "prüfen",
    "and_also": "{channel} (auch {others})",
    "noise_excess": "Die Residuen von {channels} sind {times}-mal das weiße Rauschen, das die Maschine nennt: "
    "{noise} {unit}, wo {key} {stated} {unit} ergibt",
    "noise_may_remember": "{sentence}; nicht mehr, als solches Rauschen mit Gedächtnis macht, das ± enthält",
    "noise_of_drives": "{sentence}; das Rauschen der aufgezeichneten {drives} macht davon über ihre Beschleunigungen "
    "{shaken} {unit}, was ± enthält",
    "noise_far_above": "{sentence}. Das Ergebnis nicht nutzen, bevor die Ursache bekannt ist (ein Maß, das nicht das "
    "der Maschine ist, ein langer Kontakt, kompensierte Kräfte, eine Eigenschwingung des Gestells ..): Residuen und "
    "Spektrum im Bericht ansehen",
    "noise_above": "{sentence}. Das genannte Rauschen berichtigen, oder die Ursache in den Residuen im Bericht suchen",
    "drive_noise": "Rauschen der {drives} ({sizes} von Abtastung zu Abtastung) macht Beschleunigungen unruhig, was "
    "{name} um etwa {bias} verfälscht ({deviations} Abweichungen; sie enthalten es). recording.filter_cutoff_Hz = "
    "{cutoff} senken",
    "not_shown": "Die Hälfte aller solchen Läufe zeigte nicht, was {parameter} um {amount} verfälscht ({deviations} "
    "Abweichungen), so bei {cause}",
    "not_shown_more": "{sentence}; {count} weitere, kleinere stehen unter not_shown in result.json",
    "suspected": "Die Residuen folgen vielleicht {follow}, wie bei {cause} (ein guter Lauf von {runs} sieht so aus, "
    "denn {tried} solche Dinge werden versucht). Die Abweichungen enthalten es: Die von {name} ist {times}-mal die "
    "durch Rauschen allein; ein zweiter Lauf sagt, was es ist",
    "tolerances_too_small": "Die Maschine kann in ihren Toleranzen nicht sein, wie der Fall sagt: Was der Lauf von "
    "{keys} zeigt, ist etwa {times}-mal so groß wie angegeben (von Maschinen, die wie angegeben sind, {rare} so viel), "
    "und von {tried} Maßen ragt keines heraus. Größere angeben, oder die Maschine vermessen",
    "part_off_tolerance": "Die Maschine kann in ihren Toleranzen nicht sein, wie der Fall sagt: {parts}; von "
    "Maschinen, die wie angegeben sind, mit {tried} solchen Maßen, {rare} so viel. Dieses Teil vermessen, oder "
    "angeben, was davon stimmt",
    "part_off": "{words}, und tolerances.{key} gibt {stated} an ({deviations} Abweichungen von beiden{larger})",
    "others_larger": ", wenn alle anderen {times}-mal so groß wie angegeben sind",
    "shown_by_one": "zeigt eine von {runs}",
    "shown_by_fewer": "zeigt weniger als eine von {runs}",
    "odd_clock": "Zeitstempel liegen {step} ms auseinander, {share} % neben {usual} ms, und Beschleunigungen gehen "
    "mit dem Quadrat der Zeit; ± enthält es. Hat die Uhr des Rekorders {usual} ms: recording.clock.period_ms = "
    "{usual}",
    "over_standstills": "diese {count} Stillstände",
    "over_seconds": "die {seconds} s dieses Laufs",
    "too": "; auch {others}",
    "warms_up": ", am meisten am Anfang, wie bei einem Sensor, der warm wird",
    "warm_up": "den Sensor warm werden lassen und hexcite tare aufrufen, kurz bevor seine Anzeige zählt",
    "offset_drifts": "Der Nullpunkt von {channel} driftet um {by} {unit} über {over}{how} ({sure} "
    "Standardabweichungen){more}: Das Ergebnis hat den Mittelwert; {remedy}",
    "recorded_with_another": "Er wurde mit der Maschine {before} aufgezeichnet, nicht mit {case}: {change}{more}; mit "
    "seiner eigenen auswerten",
    "another_motion": "Der Lauf ist nicht die Bewegung {which}, {names}; mit seinem eigenen Plan auswerten",
    "plan_beside": "des Plans daneben",
    "plans_beside": "eines der Pläne daneben",
    "not_the_plan": "Der Lauf ist nicht die Bewegung des Plans {name}: {share} % von dessen Bahn sind in der "
    "Aufzeichnung; ein anderes Programm lief, oder es wurde nach dem Planen geändert",
    "structural_mode": "Zwischen Antrieben und Sensoren schwingt mit der Bewegung eine Eigenform bei {frequency} Hz "
    "(Dämpfung etwa {damping} %): Sie kann {parameter} um {bias} {unit} verfälschen ({deviations} Abweichungen durch "
    "Rauschen; ± enthält es)",
    "mode_in_band": "{sentence}. Sie liegt im Band der Auswertung: recording.filter_cutoff_Hz = {cutoff} auf {lower} "
    "senken",
    "tolerances_not_counted": "Keine Toleranz aus [tolerances] ist enthalten: Das geht nicht mit Vorwissen, und nicht, "
    "wo kein Antrieb die Bewegung nennt",
    "slow_noise": "Der Lauf ist kurz für das Gedächtnis seines Rauschens: {share} % der Varianz sind von Rauschen, "
    "das ein Viertel des Laufs oder länger anhält und von dem der Lauf wenig zeigt; ± ist vielleicht bis zu 1,5-mal "
    "zu klein. Mehrmals so lang aufzeichnen, oder suchen, was driftet",
    "bag_cut": "{bag}: Das Inhaltsverzeichnis fehlt, und die Datei ist abgeschnitten: Ihre Nachrichten wurden einzeln "
    "gelesen, bis {seconds} s nach der ersten; was später aufgezeichnet wurde, ist verloren",
    "bag_without_index": "{bag}: Das Inhaltsverzeichnis fehlt, wie nach hartem Anhalten der Aufzeichnung: Ihre "
    "Nachrichten wurden einzeln gelesen, bis {seconds} s nach der ersten",
    "slow_noise_standing": "Der Stillstand ist kurz für das Gedächtnis seines Rauschens: {share} % der Varianz seiner "
    "Mittel sind von Rauschen, das ein Viertel davon oder länger anhält; ± der Nullpunkte ist um so viel größer, und "
    "noch zu klein, wo Rauschen länger anhält als der Stillstand. Mehrmals so lang aufzeichnen, oder suchen, was "
    "driftet",
    "how_smoothed": "geglättet",
    "how_sharpened": "geschärft",
    "smoothed": "Kräfte sind gegenüber der Bewegung {how}, um {size} ± {std} ms^2, das halbe zweite Moment (Sprünge "
    "zwischen Abtastungen, Mittelung oder ein Tiefpass der Kanäle): geschätzt und ausgeglichen",
    "cut_off": "Die Aufzeichnung endet, während der Trigger an ist; ihr Ende fehlt: aufzeichnen, bis die Maschine ruht",
    "no_value": "kein Messwert in {names}; weggelassen",
    "left_out": "{share} % der Bewegung sind weggelassen: Schäden, die länger als {most} Abtastungen sind, Lücken, "
    "und {reach} s auf jeder Seite, so weit das Filter reicht",
    "never_moves": "Die {drives} sind nie schneller als {least} {unit}/s, darum wird die ganze Aufzeichnung "
    "ausgewertet; einen Trigger aufzeichnen, wo nur ein Teil gemeint ist",
}
"""Findings about a run and its evaluation."""

SENTENCES = (
    FINDINGS
    | CASES
    | LOOKS
    | EFFECTS
    | PLANS
    | PROGRAMS
    | CAUSES
    | CHANNELS
    | MOTION
    | MACHINE
    | ERRORS
    | READERS
    | REPORTS
)
"""Code -> German, with the places of the English text."""

SIGNS = {
    "or": " oder ",
    "and": ", und ",
    "both": " und ",
    "comma": ", ",
    "comma_or": ", oder ",
    "semicolon": "; ",
    "problems": "; außerdem: ",
}
"""What stands between the parts of an enumeration."""
