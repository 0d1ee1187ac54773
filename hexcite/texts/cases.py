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
    "tables_of_template": "<code>{tables}</code>: noch die Werte der eingebauten Maschine {template}; durch die der "
    "eigenen "
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

WRONG = {
    "named": "{name}: {problem}",
    "not_three_angles": "{words} nennen keine drei Winkel; die von Roll, Nick, Gier schreiben: A2, B2, C2",
    "m_taken": "M{number} bedeutet der Steuerung etwas anderes; eine freie M-Funktion wählen",
    "m_twice": "trigger_on_m und trigger_off_m sind beide {number}; zwei M-Funktionen angeben",
    "linear_jerk_alone": "max_linear_jerk_mm_s3 gehört zu planner = „s_curve“; es weglassen oder diesen Planer angeben",
    "needs_linear_jerk": "max_linear_jerk_mm_s3 fehlt; [TRAJ]MAX_LINEAR_JERK aus der INI-Datei der Maschine angeben, "
    "die planner = „s_curve“ einhält",
    "no_direction": "hat keine Richtung; die Achse des Gelenks angeben, etwa [0.0, 0.0, 1.0]",
    "not_of_kind": "ist {kind} und hat kein {key}; es weglassen oder die Art ändern",
    "home_outside": "{home} = {value} liegt außerhalb von {position}; eines darin wählen",
    "two_joints": "hat zwei Gelenke {name}; jedes Gelenk braucht einen eigenen Namen",
    "no_such_body": "may_touch nennt {names}, aber kein Körper heißt so; Körper nennen: {there}",
    "no_limits": "keine Grenzen angegeben; {both}",
    "both_kinds": "{turning} stehen neben {sliding}; {both}",
    "limits_missing": "{keys} nicht angegeben; das Fehlende ergänzen",
    "without_zero": "{position} enthält 0 nicht; es zählt von der Grundstellung, weiter angeben",
    "other_joints_listed": "limits.motion.joints sind {names}; die von machine.chain nennen: {own}",
    "joints_lack": "machine.chain.joints: {what}; Grenzen der Bewegung brauchen das, es ergänzen",
    "keys_of_kind": "limits.motion.joints: {name} ist {kind}; die Schlüssel eines solchen Gelenks angeben",
    "none_there": "es gibt keine",
    "limits_of_kind": "{turning} angeben, wo es sich dreht, sonst {sliding}",
    "state_the_same": "{keys} sagen dasselbe; eines weglassen",
    "from_to": "{low} bis {high}",
    "joint_beyond": "limits.motion.joints: {name} bewegt sich von {ends}, über {own} hinaus; die Grenze enger "
    "angeben oder die Grundstellung verschieben",
    "order_once": "order = {order} nennt nicht jeden der Antriebe 1 bis 6 einmal",
    "signs_only": "sign = {sign} darf nur 1 und -1 enthalten; Maßstäbe stehen in recording.units",
    "not_a_rotation": "mounting ist keine Drehung (um {error} daneben); Zeilen müssen orthonormal und rechtshändig "
    "sein",
    "no_such_column": "columns: {ours} ist keine unserer Spalten; es sind {columns}",
    "trigger_twice": "columns.trigger und trigger.column nennen beide die Spalte des Triggers; eines weglassen",
    "column_twice": "columns ordnet {theirs} zwei unserer Spalten zu; jeder Spalte eine Bedeutung geben",
    "no_such_unit": "units.{role} = {unit} ist nicht bekannt; {units} angeben",
    "not_numbers": "{key}: {ours} ist keine unserer Spalten aus Zahlen; es sind {numbers}",
    "scale_zero": "scale.{column} ist 0, was alle Werte gleich macht; angeben, was eine 1 in der Datei ist",
    "scale_backwards": "scale.{column} ist kleiner als 0; die Zeit nimmt zu",
    "no_such_orientation": "orientation = {name} ist nicht bekannt; {remedy}",
    "names_row_outside": "names_row = {row} liegt nicht unter header_rows = {rows} Zeilen",
    "format_lacks": "{key} fehlt; Dateien von {format} sagen es nicht, oder verschieden: angeben",
    "of_the_machine": "{key} gehört zur Maschine, nicht zu einer Datei; als recording.{key} angeben",
    "ros_time": "ros.time = {time} ist nicht bekannt; 'header' oder 'receipt' angeben",
    "bar_no_length": "Stab {number} hat keine Länge; sein unterer und oberer Punkt fallen zusammen",
    "one_frame": "eines von bars, transducer und struts angeben, nicht mehrere oder keines",
    "bars_not_spanning": "die sechs Stäbe messen nicht alle Kräfte und Momente",
    "bars_must": "die Stäbe dürfen nicht alle parallel oder in einer Ebene liegen oder eine Gerade treffen",
    "no_such_inertia": "kein starrer Körper hat die Hauptträgheiten {values} kg m^2; alle müssen positiv sein und "
    "keine größer als die Summe der anderen",
    "std_or_limit": "eine Standardabweichung angeben, etwa 0.03, oder {{ limit = 0.05 }}, nicht beides oder keines",
    "tcp_without_flange": "tcp liegt im Flansch, der nicht angegeben ist; flange = {{ origin_mm = [0.0, 0.0, 0.0] }} "
    "ergänzen",
    "not_spanning": "{problem} (Kondition {condition}, höchstens {most}); {remedy}",
    "points_or_ring": "points_mm (sechs [x, y, z]) oder ring angeben, nicht beides oder keines",
    "box_no_side": "{name} hat kein x_mm, y_mm oder z_mm; wenigstens eine Seite angeben, sonst darf sich nichts "
    "bewegen",
    "axis_or_corners": "die Achse (from_mm, to_mm) oder corners_mm angeben, eines davon",
    "from_with_to": "from_mm gehört zu to_mm; neben corners_mm weglassen",
    "range_without_zero": "{name} = [{low}, {high}] enthält 0 nicht; es zählt von der Grundstellung, weiter angeben",
    "missing_or": "{key} fehlt; es ergänzen, oder {other}",
    "beyond_workspace": "limits.motion.{name} = {inner} reicht über workspace.{name} = {outer} hinaus; das eine "
    "enger oder das andere weiter angeben",
    "no_common_length": "limits.motion.strut_length_mm und workspace.strut_length_mm haben keine Länge gemeinsam; "
    "eines berichtigen",
    "ring_form": "ein Ring hat half_angle_deg oder included_angle_deg, eines davon, mit pair_centres_deg, oder nur "
    "angles_deg; so angeben",
    "mass_below_0": "mass_kg beginnt bei {mass}; kein Körper hat weniger als 0",
    "value_and_U": "{value} und {expanded} angeben, oder keines: E_n braucht die Unsicherheit des Vergleichswerts",
    "mass_or_centre": "mass_kg und mass_U_kg angeben, oder centre_of_gravity_mm und centre_of_gravity_U_mm",
    "no_built_in": "{value} ist keine eingebaute Maschine; die Zeile löschen",
    "of_other_machine": "{key} gehört zu {of}, oder ist unvollständig; es schreiben wie in der Maschine {like}",
    "setup_2x": "setup „2x“ gehört zu [sensor_frame.struts] und einem Hexapod: Sensoren in seinen Streben; eines "
    "davon ändern",
    "without_chain": "sensor_frame.transducer.{key} ist für Maschinen ohne Kette; als machine.chain.{key} angeben",
    "no_shaking_in_struts": "sensors: Rauschen der Beschleunigungen zählt noch nicht, wo Sensoren in Streben sitzen; "
    "es weglassen",
    "pose_error_missing": "sensors: pose_error_N oder pose_error_length_mm fehlt; beide angeben, wie hexcite "
    "identify sie nennt",
    "bounds_in_1a": "bounds sind die eines bewegten Körpers; in Aufbau 1a wird keiner bestimmt: weglassen",
    "not_tolerable": "tolerances.{key} ist von etwas, das diese Maschine nicht hat; sie hat {tolerable}",
    "gravity_size": "ist {size} m/s^2 lang; auf der Erde sind es {least} bis {most}: die örtliche Fallbeschleunigung "
    "in {{B}} angeben, etwa [0.0, 0.0, -9.81]",
    "a_chain": "einer Kette",
    "a_hexapod": "einem Hexapod",
    "or_add_chain": "hexapod, oder [machine.chain] ergänzen",
    "safe_feed": "controller.safe_feed_mm_min fehlt oder ist schneller als limits.motion.velocity_mm_s; den Vorschub "
    "der ersten Bewegung angeben, höchstens {most} mm/min",
    "setup_R": "setup „R“, und machine.chain, gehören zu einem Kraft-Momenten-Sensor: setup = „R“ und "
    "[sensor_frame.transducer] schreiben, oder den Aufbau der Stäbe",
    "moment_noise": "sensors.moment_noise_Nm gehört zu force_noise_N eines Kraft-Momenten-Sensors, Kraftsensoren "
    "brauchen es nicht; eines ergänzen oder weglassen",
    "force_noise_missing": "sensors.force_noise_N fehlt; weights = „stated“ und Rauschen der Beschleunigungen "
    "brauchen es, aus dem Datenblatt der Sensoren",
    "pose_error_of_bars": "sensors.pose_error_N = {size} ist für Stäbe, die Streben bewegen (Aufbau 1b); es und "
    "pose_error_length_mm weglassen",
    "limits_swapped": "die untere Grenze {low} liegt nicht unter der oberen {high}; tauschen oder weiter angeben",
    "not_a_grid": "[{first}, {last}, {step}] ist nicht [erster, letzter, Schritt]; vom ersten zum letzten aufwärts "
    "gehen",
    "not_spelled": "{value}: ist nicht, was hier stehen kann ({words}); den Wert berichtigen",
    "control_characters": "{value}: enthält Steuerzeichen, denen ein Terminal oder eine Steuerung folgte; sie "
    "entfernen",
    "at_key": "{key}: {words}",
    "missing": "fehlt; es ergänzen",
    "a_number": "eine Zahl, ohne Anführungszeichen und mit Punkt",
    "a_whole_number": "eine ganze Zahl",
    "a_list": "eine Liste",
    "not_a_table": "{value}: ist keine Tabelle; {table} schreiben",
    "above": "größer als {bound}",
    "from": "mindestens {bound}",
    "below": "kleiner als {bound}",
    "up_to": "höchstens {bound}",
    "not_a": "{value}: ist nicht {what}; so schreiben",
    "out_of_bounds": "{value}: muss {bound} sein; den Wert berichtigen",
    "one_of": "{value}: muss eines von {choices} sein; den Wert berichtigen",
    "entries_at_least": "mindestens {count}",
    "entries_at_most": "höchstens {count}",
    "entries": "hat {count} Einträge, {expected} sind nötig; berichtigen (ein Dezimalkomma macht zwei Einträge)",
    "wrong_value": "{value}: {why}; den Wert berichtigen",
    "other_unit": "hat keine Einheit, oder eine andere als hier nötig; {keys} schreiben",
    "unknown_key_near": "ist ein unbekannter Schlüssel; ist {near} gemeint? bekannt sind hier {known}",
    "unknown_key": "ist ein unbekannter Schlüssel; bekannt sind hier {known}",
    "more_problems": "hat {count} weitere Fehler; diese zuerst berichtigen",
    "with_remedy": "{problem}; {remedy}",
    "at_place": "{place}: {problem}",
}
"""What tables of a case cannot be."""

PURPOSES = {
    "a URScript program": "ein URScript-Programm",
    "a comparison": "ein Vergleich",
    "a demo": "eine Vorführung",
    "a joint trajectory": "eine Trajektorie der Gelenke",
    "a manual motion": "eine Bewegung von Hand",
    "a payload": "eine Nutzlast",
    "a plan": "ein Plan",
    "a plan of poses": "ein Plan aus Posen",
    "a program": "ein Programm",
    "a program for LinuxCNC": "ein Programm für LinuxCNC",
    "a proposal of the motion box": "ein Vorschlag für den Bereich der Bewegung",
    "a recording": "eine Aufzeichnung",
    "a run": "ein Lauf",
    "a setpoint table": "eine Tabelle von Sollwerten",
    "a study": "eine Studie",
    "a study that executes its plans": "eine Studie, die ihre Pläne ausführt",
    "a validation": "eine Validierung",
    "home": "die Grundstellung",
    "identifiability": "die Bestimmbarkeit",
    "moves between poses": "Bewegungen zwischen Posen",
    "planning": "das Planen",
    "point-to-point moves in whole controller cycles": "Bewegungen in ganzen Takten der Steuerung",
    "pose candidates": "Kandidaten für Posen",
    "predicted standard deviations": "vorausgesagte Standardabweichungen",
    "re-timing": "neue Zeiten",
    "re-timing in whole controller cycles": "neue Zeiten in ganzen Takten der Steuerung",
    "the check of a program": "die Prüfung eines Programms",
    "the check of a table": "die Prüfung einer Tabelle",
    "the check of its reach": "die Prüfung dessen, was erreichbar ist",
    "the comparison with a plan": "der Vergleich mit einem Plan",
    "the comparison with the truth": "der Vergleich mit der Wahrheit",
    "the demo": "die Vorführung",
    "the expected load": "die erwartete Last",
    "the forces of the sensors": "die Kräfte der Sensoren",
    "the information limit": "die Grenze der Information",
    "the kinematics": "die Kinematik",
    "the match of poses": "die Zuordnung von Posen",
    "the motion of struts": "die Bewegung der Streben",
    "the picture of the machine": "das Bild der Maschine",
    "the pose at home": "die Pose in Grundstellung",
    "the proof of limits": "der Beweis der Grenzen",
    "the reach of the motion box": "die Reichweite",
    "the reference scaling": "die Bezugsskalierung",
    "the report": "der Bericht",
    "the simulation of sensor forces": "die Simulation der Kräfte",
    "the uncertainty of exported forces": "die Unsicherheit exportierter Kräfte",
    "the validation": "die Validierung",
    "the validity of poses": "die Gültigkeit von Posen",
}
"""What something is needed for."""

NEEDED = {
    "is_missing": "fehlt",
    "purpose_needs": "nötig für: {purpose}; die Tabelle in der Datei der Maschine ergänzen",
    "for_chains": "ist ein Hexapod; nur Ketten von Gelenken kennen das: {purpose}",
    "for_hexapods": "nur Hexapode kennen das: {purpose}",
    "none_of_a_chain": "eine Kette hat noch keines",
}
"""What a purpose needs of a case."""

CASES = DOUBTS | CHECKED | WRONG | NEEDED
"""All of them."""
