"""German for what is doubtful or wrong in a case, by code."""

DOUBTS = {
    "stated": "{key} {how} {value}",
    "times_that": "das {factor}-fache davon",
    "one_is_wrong": "{value} neben {others}: {why}; eines davon ist falsch",
    "correct_value": "{value}: {why}; berichtigen",
    "beside": "{values} neben {others}",
    "and_so_on": "{keys} und so weiter",
    "looks_like": "{values}: {why}; sieht nach {units} aus: {keys} schreiben",
    "look_like": "{values}: {why}; sehen nach {units} aus: {keys} schreiben",
    "unit_m": "Metern",
    "unit_mm": "Millimetern",
    "unit_um": "Mikrometern",
    "unit_rad": "Radiant",
    "unit_deg": "Grad",
    "unit_s": "Sekunden",
    "unit_converted": "Grad, die für Radiant gehalten und umgerechnet wurden,",
    "and_more_values": "{values} und {count} weitere",
    "velocity_jerk_allow": "Geschwindigkeit und Ruck erlauben eine Beschleunigung von {size} {unit}",
    "reached_on": "bei dieser Beschleunigung wird die Geschwindigkeit auf {share} % des Bereichs erreicht",
    "more_than_any": "{size} {unit} ist mehr, als eine solche Maschine hat",
    "go_with": "auf 1 rad kommen {first} m bei den ersten beiden, {second} m bei den anderen",
    "with_widths": "mit Breiten",
    "with_width": "mit einer Breite von",
    "with_distances": "mit Abständen",
    "at_most_from_origin": "höchstens vom Ursprung",
    "with_x_y": "mit x und y, vom Ursprung",
    "asked_of_strut": "in der Grundstellung verlangen die Grenzen der Plattform {size} {unit} von einer Strebe",
    "other_joints": "andere Gelenke haben {times}-mal so viel",
    "many_turns": "{turns} Umdrehungen sind mehr, als Gelenke machen",
    "joints_turn_by": "die meisten Gelenke drehen sich um höchstens {angle} Grad",
    "origins_sum": "die Ursprünge der Gelenke ergeben zusammen {size} m",
    "noise_of_range": "das Rauschen ist {share} % des Bereichs",
    "weight_loads": "allein das Gewicht des Körpers belastet einen Sensor mit {load} N",
    "noise_of_weight": "das Rauschen ist {share} % des Gewichts",
    "too_dense": "kein Stoff ist dicht genug für einen so kleinen Körper ({size} um seinen Schwerpunkt)",
    "machine_size": ", die Maschine hat {size}",
    "mass_lies": "die Masse liegt {size} von ihrem Schwerpunkt{machine}",
    "it_lies": "er liegt {size} vom Ursprung von {{P}}{machine}",
    "it_and_mass_lie": "er liegt {size} vom Ursprung von {{P}}, die Masse {gyration} von ihm",
    "too_small": "{size} ist zu klein für eine Maschine, die Kraftsensoren trägt",
    "times_the_other": "eines ist {times}-mal das andere",
    "not_an_angle": "{angle} Grad ist kein Winkel von Gelenken",
    "nobody_has": "keine solche Steuerung und kein solcher Rekorder hat das",
    "half_the_rate": "die halbe Rate ist die höchste Frequenz, die Abtastungen enthalten",
    "block_and_cycle": "ein Satz dauert mindestens einen Takt",
    "link_far": "link.centre_of_gravity_mm von {joints}: der von {name} liegt {away} von seinem Gelenk, der nächste "
    "Rahmen {length}, als wäre er von einem anderen aus gezählt; berichtigen, oder link weglassen, dann begrenzt "
    "torque_Nm nichts",
    "earlier_moves": "von einer früheren Version ist: Bewegungen werden mit Vorschub geschrieben",
    "earlier_look_ahead": "von einer früheren Version ist: die virtuelle Steuerung folgt Bahnen, wie sie stehen",
    "earlier_key": "{key}, das {what}; die Zeile löschen",
}
"""Values that contradict each other."""

CHECKED = {
    "move_home_or": "die Grundstellung verschieben, oder {other}",
    "home_or_bodies": "eine andere Grundstellung wählen, oder einen der beiden Körper kleiner machen oder weglassen",
    "or_other_home": "{other}, oder eine andere Grundstellung wählen",
    "other_home": "eine andere Grundstellung wählen",
    "look_at": "zu prüfen: {doubt}",
    "home_cannot_be": "die Grundstellung ist nicht möglich: {why}",
    "delete_template": '; sobald alle Werte die eigenen sind, die Zeile template = "{template}" löschen',
    "tables_of_template": "{tables}: noch die Werte der eingebauten Maschine {template}; durch die der eigenen "
    "ersetzen, oder "
    "Tabellen löschen, die sie nicht braucht{done}",
    "keys_of_template": "{keys}: noch die Werte der eingebauten Maschine {template}; durch die der eigenen "
    "ersetzen{done}",
    "torques_limit_nothing": "machine.chain.joints: torque_Nm und force_N begrenzen nichts, denn das Glied von "
    "{joints} ist nicht "
    "angegeben; Masse, Schwerpunkt und Trägheit ergänzen",
    "gravity_points_up": "gravity_m_s2 = {value} zeigt entlang +z von {{B}}; die Schwerkraft zeigt nach unten: das "
    "Vorzeichen "
    "ändern, wenn die Maschine nicht hängt",
}
"""Remarks of a check."""

CASES = DOUBTS | CHECKED
"""All of them."""
