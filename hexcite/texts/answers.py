"""German words for what commands answer by codes: limits, parameters, checks, causes, findings, reasons, errors."""

LIMITS = {
    "position": "Position",
    "angle": "Winkel",
    "workspace position": "Position im Arbeitsraum",
    "joint position": "Gelenkposition",
    "joint angle": "Gelenkwinkel",
    "velocity": "Geschwindigkeit",
    "angular velocity": "Winkelgeschwindigkeit",
    "acceleration": "Beschleunigung",
    "angular acceleration": "Winkelbeschleunigung",
    "jerk": "Ruck",
    "angular jerk": "Winkelruck",
    "strut length": "Strebenlänge",
    "strut velocity": "Strebengeschwindigkeit",
    "strut acceleration": "Strebenbeschleunigung",
    "base joint angle": "Winkel am Basisgelenk",
    "platform joint angle": "Winkel am Plattformgelenk",
    "singularity": "Nähe zu einer Singularität",
    "distance from": "Abstand von",
    "distance between links": "Abstand zwischen Gliedern",
    "joint force": "Gelenkkraft",
    "joint torque": "Drehmoment am Gelenk",
    "sensor force": "Kraft am Sensor",
    "sensor moment": "Moment am Sensor",
    "feed to home": "Vorschub zur Grundstellung",
    "untimed moves": "Bewegungen ohne Zeitvorgabe",
    "way home": "Weg zur Grundstellung",
}
"""Kinds of limits and of moves."""

PLACES = {"strut": "Strebe", "sensor": "Sensor", "joint": "Gelenk", "channel": "Kanal", "tool": "Werkzeug"}
"""First word of the place where a limit is closest."""

STATUSES = {
    "proven": "bewiesen",
    "follows from what the controller enforces": "folgt aus dem, was die Steuerung einhält",
    "enforced by controller": "hält die Steuerung ein",
    "NOT enforced": "hält niemand ein",
    "left out, as planned": "weggelassen, wie geplant",
    "steps, not limited by controller": "springt, von der Steuerung nicht begrenzt",
}

_AXES = "xyz"
PARAMETERS = (
    {"m": "Masse"}
    | {f"{axis}C": f"Schwerpunkt {axis}" for axis in _AXES}
    | {f"IC{i}{j}": f"Trägheit {a}{b}" for i, a in enumerate(_AXES, 1) for j, b in enumerate(_AXES, 1)}
    | {
        "k0": "Verformung: Kraft durch Verschiebung",
        "k1": "Verformung: Moment durch Verschiebung",
        "k2": "Verformung: Kraft durch Kippung",
        "k3": "Verformung: Moment durch Kippung",
    }
    | {f"f_q0_{k}": f"Nullpunkt von Kanal {k}" for k in range(1, 7)}
    | {f"K{n}_{k}{a}": f"Verformung: Kanal {k} durch {a}" for n in "134" for k in range(1, 7) for a in _AXES}
)
_OF_STRUTS = {
    "mu": "Masse einer Stange",
    "h": "statisches Moment einer Stange",
    "k": "Trägheit von Stange und Rohr",
    "d": "statisches Moment eines Rohrs",
    "cB": "viskose Reibung eines Basisgelenks",
    "cP": "viskose Reibung eines Plattformgelenks",
    "tB": "Coulombsche Reibung eines Basisgelenks",
    "tP": "Coulombsche Reibung eines Plattformgelenks",
}
PARAMETERS |= _OF_STRUTS | {f"{n}_{k}": f"{words}, Strebe {k}" for n, words in _OF_STRUTS.items() for k in range(1, 7)}

CHECKS = {
    "warnings": "Warnungen, die keine Abweichung zählt",
    "noise": "Rauschen von Kanal {of} im Verhältnis zum angegebenen",
    "mass": "Masse, Abweichung vom Nennwert",
    "path": "Bahn des Plans im Lauf",
    "duration": "Dauer, Abweichung vom Plan",
    "path_error": "Bahnfehler",
    "deviation": "Abweichung von {of}",
    "reference": "E_n von {of}",
}
"""What is judged, by its code."""

CAUSES = {
    "noise": "Rauschen",
    "noise with memory": "Rauschen mit Gedächtnis",
    "seen in residuals": "in den Residuen gesehen",
    "drawing": "Zeichnung",
    "gains": "Verstärkungen",
    "alignment": "Lage des Sensors",
    "gravity": "Schwerkraft",
    "encoders": "Geber",
    "clock": "Uhr",
    "priors": "Vorwissen",
    "model": "Modell",
}
"""Causes of deviations."""

FINDINGS = {
    "format": "So wurde die Datei gelesen.",
    "damage": "Ein Teil der Aufzeichnung ist beschädigt und bleibt außer Betracht.",
    "window": "Nur ein Teil der Aufzeichnung zählt.",
    "clock": "Mit den Uhren oder Zeitstempeln stimmt etwas nicht.",
    "contact": "Die Maschine scheint etwas zu berühren.",
    "feed": "Der Vorschub war ein anderer als geplant.",
    "program": "Der Lauf war ein anderer als das Programm.",
    "noise": "Das Rauschen ist ein anderes als angegeben.",
    "model": "Das Modell erklärt nicht, was gemessen wurde, oder ein Wert ist unmöglich.",
    "estimator": "Die Schätzung hat Bedingungen oder Vorwissen benutzt.",
    "offsets": "Die Nullpunkte driften.",
    "case": "Die Beschreibung der Maschine passt nicht oder wurde geändert.",
}
"""Kinds of findings."""

ERRORS = {
    "missing": "Etwas, das nötig ist, fehlt.",
    "unknown": "Einen Namen gibt es nicht.",
    "wrong_kind": "Ein Wert, ein Text oder eine Datei ist von anderer Art als erwartet.",
    "out_of_range": "Ein Wert liegt außerhalb dessen, was möglich ist.",
    "contradiction": "Zwei Angaben schließen sich aus.",
    "unit": "Mit einer Einheit, einem Maßstab oder der Reihenfolge von Winkeln stimmt etwas nicht.",
    "clock": "Mit Zeitstempeln, Raten oder Uhren stimmt etwas nicht.",
    "trigger": "Mit dem Trigger stimmt etwas nicht.",
    "exists": "Dort steht schon etwas.",
    "not_writable": "Dorthin lässt sich nicht schreiben.",
    "unreadable": "Das lässt sich nicht lesen.",
    "damaged": "Eine Datei ist beschädigt oder unvollständig.",
    "changed": "Eine Datei wurde von Hand geändert.",
    "stale": "Die Maschine wurde seither geändert.",
    "version": "Eine Datei ist von einer anderen Version.",
    "other_source": "Etwas gehört zu einer anderen Maschine oder Aufzeichnung.",
    "syntax": "Ein Programm ist nicht lesbar.",
    "not_proven": "Es ist nicht bewiesen, dass das Programm die Grenzen einhält.",
    "infeasible": "In diesen Grenzen gibt es keine solche Bewegung oder Pose.",
    "no_excitation": "Diese Daten bestimmen die Parameter nicht.",
    "too_few": "Es sind zu wenige Werte, Posen oder Stillstände.",
    "no_convergence": "Die Rechnung kam zu keinem Ende.",
    "misfit": "Diese Daten passen nicht zum Modell der Maschine.",
    "not_supported": "Das kann diese Maschine, Steuerung oder Datei nicht.",
    "not_installed": "Etwas ist nicht installiert.",
    "run_failed": "Eine Steuerung oder ein anderes Programm ist gescheitert.",
    "internal": "Ein Fehler von hexcite selbst; bitte melden.",
}
"""Codes of refusals."""

REASONS = {
    "our_name": "sie heißt wie bei hexcite",
    "name": "nach ihrem Namen",
    "case_names": "die Maschine nennt sie",
    "case_states": "die Maschine sagt es",
    "format": "das Format der Datei sagt es",
    "two_columns": "nach ihrem Namen; ganze Sekunden, zu denen {column} Nanosekunden zählt",
    "ticks": "ihre Zahlen sind Takte von 100 ns und laufen mit den Zeilen weiter",
    "runs_on": "nach ihrem Namen, und ihre Zahlen laufen mit den Zeilen weiter",
    "alone_changes": "von denen, die es dem Namen nach sein können, ändert nur sie sich",
    "are_lengths": "ihre Werte sind Längen, welche die Streben haben können",
    "wrench": "der Sensor der Maschine hat Kräfte und Momente",
    "dates": "Datum oder Uhrzeit",
    "label": "ihre Beschriftung oder die Zeile der Einheiten sagt es",
    "our_unit": "nicht angegeben, darum die des Namens bei hexcite",
    "our_unit_fits": "nicht angegeben; die Werte passen zu dieser",
    "rate": "ihre Schritte sind dann {rate} Zeilen je Sekunde, wie Rekorder sie haben",
    "lengths": "ihre Werte sind dann Längen, welche die Streben haben können",
    "ends": "ihre Werte liegen dann zwischen den Enden der Gelenke",
    "near_home": "die Plattform steht damit nahe ihrer Grundstellung",
    "small": "ihre Werte sind klein",
    "no_unit": "keine Einheit dieser Größe; ein Maßstab muss sagen, was eine 1 ist",
    "header": "der Kopf der Datei sagt es",
    "first_lines": "die ersten Zeilen der Datei sagen es",
    "numbers": "damit sind die meisten Spalten in den meisten Zeilen Zahlen",
    "first_row": "Zeile {line} ist die erste mit Zahlen",
    "known_names": "von den Zeilen über den Zahlen die mit den bekanntesten Namen",
    "last_row": "Zeilen unter der letzten Zahlenzeile",
    "no_names": "keine Zeile der Datei nennt die Spalten",
    "not_utf8": "der Text ist nicht UTF-8",
    "several_clocks": "Zeilen mehrerer Uhren stehen durcheinander",
    "where_changed": "Werte stehen nur, wo sie sich ändern",
    "other_names": "Namen, die von unseren abweichen",
    "other_units": "Einheiten, die von denen unserer Namen abweichen",
    "bit": "nur Bit {bit} ändert sich",
    "orientation": "{conventions} nach den Namen; nach den Werten kann es dies sein",
    "filter": "üblich, und höchstens ein Fünftel der Zeilen je Sekunde",
    "joints_of": "Positionen der Gelenke von {topic}, nach ihren Namen",
    "wrench_of": "Kräfte und Momente von {topic}, nach ihren Namen",
    "messages": "die von Nachrichten dieser Art",
    "clock": "nach der Uhr der Datei",
}
"""Why a file is taken for what it is."""

TITLES = {
    "clamping_table": "Spanntisch auf sechs einachsigen Kraftsensoren, Gestell in Ruhe",
    "five_axis_table": "Fünfachsmaschine, Kraft-Momenten-Sensor unter der Spannvorrichtung ihres Schwenktischs",
    "ft_wrist": "Sechsachsiger Kraft-Momenten-Sensor an einem bewegten Flansch",
    "hexapod": "Hexapod-Werkzeugmaschine, bewegte Plattform mit sechs einachsigen Kraftsensoren",
    "strut_sensors": "Hexapod-Werkzeugmaschine mit sechs einachsigen Kraftsensoren in ihren Streben",
    "ur10_wrist": "UR10e mit sechsachsigem Kraft-Momenten-Sensor am Flansch",
}
"""Built-in machines."""
