"""Words of the start page and the stage Machine: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
    "which_machine": ("Which machine?", "Welche Maschine?"),
    "start_lead": (
        "Six stages lead from the drawing of a machine to a proven program, and from its recorded run to calibrated "
        "values. Everything is kept in the folder named above; nothing leaves this computer.",
        "Sechs Schritte führen von der Zeichnung einer Maschine zum bewiesenen Programm und vom aufgezeichneten Lauf "
        "zu kalibrierten Werten. Alles steht im oben genannten Ordner; nichts verlässt diesen Rechner.",
    ),
    "kept_apart": ("Kept apart:", "Auseinandergehalten:"),
    "boxes": ("Boxes that nothing enters:", "Kästen, in die nichts gerät:"),
    "no_bodies": ("none", "keine"),
    "may_touch": ("May touch:", "Dürfen sich berühren:"),
    "bare_parts": (
        "Without a body, so that nothing keeps them clear:",
        "Ohne Körper, sodass nichts sie fernhält:",
    ),
    "part_surroundings": ("surroundings", "Umgebung"),
    "part_tool": ("tool", "Werkzeug"),
    "shape_round": ("round", "rund"),
    "shape_hull": ("hull", "Hülle"),
    "state_missing": ("State what is missing ({count})", "Fehlendes angeben ({count})"),
    "plan_needs": ("To plan a motion, state:", "Um eine Bewegung zu planen, angeben:"),
    "to_machine": ("State them: Machine", "Angeben: Maschine"),
    "own_machines": ("Your machines in this folder", "Ihre Maschinen in diesem Ordner"),
    "built_in": ("Built in, to try it", "Eingebaut, zum Ausprobieren"),
    "built_in_note": (
        "Their sensors are simulated; all stages can be tried without a machine.",
        "Ihre Sensoren sind simuliert; alle Schritte lassen sich ohne Maschine ausprobieren.",
    ),
    "new_machine": ("A machine of your own", "Eine eigene Maschine"),
    "new_name": (
        "Name of its folder: small letters, digits and underscores; HX-260 becomes hx_260",
        "Name ihres Ordners: Kleinbuchstaben, Ziffern und Unterstriche; aus HX-260 wird hx_260",
    ),
    "begin_like": (
        "Which one is most like it? You replace its values by those of your drawing; what counts is where the force "
        "sensors are.",
        "Welche ist ihr am ähnlichsten? Ihre Werte ersetzen Sie durch die Ihrer Zeichnung; entscheidend ist, wo die "
        "Kraftsensoren sitzen.",
    ),
    "copy_of": ("A copy of {what}", "Eine Kopie von {what}"),
    "sensors_1a": ("Sensors in a frame that stands still", "Sensoren in einem Gestell, das stillsteht"),
    "sensors_1b": ("Sensors in the moving platform", "Sensoren in der bewegten Plattform"),
    "sensors_2x": ("Sensors in the struts", "Sensoren in den Streben"),
    "sensors_R": ("One force/torque sensor", "Ein Kraft-Momenten-Sensor"),
    "controls": ("Programs for", "Programme für"),
    "no_motion": (
        "No motion is planned: recordings are evaluated.",
        "Keine Bewegung wird geplant: Aufzeichnungen werden ausgewertet.",
    ),
    "begin_urdf": ("Or begin from the URDF file of a robot", "Oder mit der URDF-Datei eines Roboters beginnen"),
    "flange": (
        "Link of the URDF that carries the sensor, such as tool0",
        "Glied der URDF, das den Sensor trägt, etwa tool0",
    ),
    "sensor_link": ("Link whose frame is the sensor's", "Glied, dessen Achsen die des Sensors sind"),
    "sensor_same": ("the same link", "dasselbe Glied"),
    "keep_bodies": (
        "Keep links and tool apart, by the collision bodies of the file",
        "Glieder und Werkzeug auseinanderhalten, nach den Kollisionskörpern der Datei",
    ),
    "joints_title": ("Joints: home and limits of motion", "Gelenke: Grundstellung und Grenzen der Bewegung"),
    "joints_note": (
        "Home is where programs begin and end. Ranges are relative to it; give what a motion may use of each joint.",
        "In der Grundstellung beginnen und enden Programme. Bereiche zählen von ihr aus; anzugeben ist, was eine "
        "Bewegung von jedem Gelenk nutzen darf.",
    ),
    "joints_state": (
        "State these {count} values too: now they are proposals, and typing one states all of them",
        "Auch diese {count} Werte angeben: Noch sind es Vorschläge; wer einen eingibt, gibt alle an",
    ),
    "joint": ("joint", "Gelenk"),
    "all_joints": ("all joints", "alle Gelenke"),
    "of_all_joints": ("{what} of all joints", "{what} aller Gelenke"),
    "column_home": ("home", "Grundstellung"),
    "column_position": ("range", "Bereich"),
    "column_velocity": ("velocity", "Geschwindigkeit"),
    "column_acceleration": ("acceleration", "Beschleunigung"),
    "column_jerk": ("jerk", "Ruck"),
    "make": ("Make it", "Anlegen"),
    "problem": ("This case cannot be read", "Diese Maschine ist nicht lesbar"),
    "from_above": ("from above, mm", "von oben, mm"),
    "from_side": ("from the side, mm", "von der Seite, mm"),
    "strut_lengths": (
        "Strut lengths at home in mm: compare them with the control's display",
        "Strebenlängen in der Grundstellung in mm: mit der Anzeige der Steuerung vergleichen",
    ),
    "values": ("Values", "Werte"),
    "values_note": (
        "The picture follows while you type; nothing is written before you save. {B} are the axes of the base, "
        "{P} those of the platform or sensor.",
        "Das Bild folgt der Eingabe; geschrieben wird erst beim Speichern. {B} sind die Achsen der Basis, {P} die "
        "der Plattform oder des Sensors.",
    ),
    "save": ("Save", "Speichern"),
    "saved": ("Saved.", "Gespeichert."),
    "changed_elsewhere": (
        "The file was changed elsewhere meanwhile; your values are below. Compare, then save again.",
        "Die Datei wurde inzwischen anderswo geändert; Ihre Werte stehen unten. Vergleichen, dann erneut speichern.",
    ),
    "read_only": (
        "A built-in machine stays as it is. Begin your own from it to change values.",
        "Eine eingebaute Maschine bleibt, wie sie ist. Zum Ändern eine eigene damit beginnen.",
    ),
    "check": ("Check reach and doubtful values", "Reichweite und zweifelhafte Werte prüfen"),
    "propose": ("Look for the largest reachable box", "Größten erreichbaren Bereich suchen"),
    "reach": (
        "{share} % of the motion box is within reach; farthest out: {limit}.",
        "{share} % des Bewegungsbereichs sind erreichbar; am weitesten außen: {limit}.",
    ),
    "reach_note": (
        "That is no fault: motions are searched for in the part that is.",
        "Das ist kein Fehler: Bewegungen werden im erreichbaren Teil gesucht.",
    ),
    "no_doubts": ("No value is doubtful.", "Kein Wert ist zweifelhaft."),
    "of_example": ("{count} of the example", "{count} vom Beispiel"),
    "proposal": (
        "This box is within reach as a whole; its values are for limits.motion below.",
        "Dieser Bereich ist ganz erreichbar; seine Werte gehören unten in limits.motion.",
    ),
    "no_picture": ("There is no picture of this machine:", "Von dieser Maschine gibt es kein Bild:"),
    "not_ready": ("Not complete yet:", "Noch nicht vollständig:"),
    "near_home": ("What the machine comes closest to at home", "Was der Maschine in der Grundstellung am nächsten ist"),
    "at_home": ("at home", "in Grund\u00adstellung"),
    "ends": ("allowed", "erlaubt"),
    "near_hit": ("exceeded", "überschritten"),
    "near_close": ("close", "knapp"),
    "space_note": (
        "Drag to turn, Ctrl and wheel or two fingers to zoom.",
        "Ziehen dreht, Strg mit Rad oder zwei Finger vergrößern.",
    ),
    "home_sliders": ("Joints at home", "Gelenke in der Grundstellung"),
    "home_sliders_note": (
        "Picture and distances follow; written when you save the values below.",
        "Bild und Abstände folgen; geschrieben wird beim Speichern der Werte unten.",
    ),
    "tried_only": (
        "To try it; a built-in machine stays as it is.",
        "Zum Ausprobieren; eine eingebaute Maschine bleibt, wie sie ist.",
    ),
    "sensor_turn": (
        "How the sensor is turned on the last joint",
        "Wie der Sensor am letzten Gelenk gedreht ist",
    ),
    "sensor_turn_note": (
        "In degrees, about x, then y, then z of the joint's frame. The picture shows the axes on the sensor.",
        "In Grad, um x, dann y, dann z des Gelenks. Das Bild zeigt die Achsen, die auf dem Sensor stehen.",
    ),
    "turn_by": ("turn about {axis} by {by} degrees", "um {axis} um {by} Grad drehen"),
    "urdf_title": ("Robot {name}", "Roboter {name}"),
    "urdf_lead": (
        "Which link carries the sensor? Click it in the picture, or choose it. All joints stand at 0 here.",
        "Welches Glied trägt den Sensor? Im Bild anklicken oder auswählen. Alle Gelenke stehen hier auf 0.",
    ),
    "joints_before": ("moved by {count} joints", "von {count} Gelenken bewegt"),
    "mark_example": ("still that of the example", "noch der Wert des Beispiels"),
    "mark_typical": ("a typical value, to be replaced", "ein üblicher Wert, noch zu ersetzen"),
    "examples_left": (
        "{count} values below are still those of the example: replace them, and say so where one is right.",
        "{count} Werte unten sind noch die des Beispiels: ersetzen, und bestätigen, wo sie stimmen.",
    ),
    "all_mine": ("All values are mine", "Alle Werte sind meine"),
    "mark_mine": ("yours", "Ihr Wert"),
    "mark_missing": ("not stated", "nicht angegeben"),
    "mark_doubtful": ("implausible", "unglaubhaft"),
    "mark_needed": ("needed", "nötig"),
    "unit_of": ("Unit of {what}", "Einheit von {what}"),
    "angle_half": ("half angle", "halber Winkel"),
    "angle_included": ("included angle", "ganzer Winkel"),
    "angles_sketch": (
        "Two joints of a pair: the half angle is from the centre of the pair to a joint, the included one from joint "
        "to joint.",
        "Zwei Gelenke eines Paars: Der halbe Winkel reicht von der Mitte des Paars zum Gelenk, der ganze von Gelenk "
        "zu Gelenk.",
    ),
    "numbers_sketch": (
        "Strut 1 leads from joint 1 of the base to joint 1 of the platform, and so on. Joints 1 and 2 are a pair on "
        "the base; on the platform they mostly lie far apart, and it is 2 and 3 that lie close. State the angle "
        "between 1 and 2 for both.",
        "Strebe 1 führt von Gelenk 1 der Basis zu Gelenk 1 der Plattform und so weiter. 1 und 2 sind auf der Basis ein "
        "Paar; auf der Plattform liegen sie meist weit auseinander, und 2 und 3 liegen nah beieinander. Für beide ist "
        "der Winkel zwischen 1 und 2 anzugeben.",
    ),
    "holds": ("Holds:", "Enthält:"),
    "take": ("Take", "Übernehmen:"),
    "converted": ("In the file: {what}", "In der Datei: {what}"),
    "refused_fields": (
        "{count} of the values below cannot be, and nothing was written; why stands at each:",
        "{count} der Werte unten gehen nicht, und nichts wurde geschrieben; warum, steht bei jedem:",
    ),
    "more_keys": ("Switch on what is not stated", "Einschalten, was nicht angegeben ist"),
    "switch_all": ("all of these, with the values below", "alle, mit den Werten darunter"),
    "not_stated": ("not stated", "nicht angegeben"),
    "take_box": ("Take this box into the machine", "Diesen Bereich in die Maschine übernehmen"),
}
