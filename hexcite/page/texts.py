"""The words of the page in English and German; what commands answer is English."""

from typing import Literal

Language = Literal["en", "de"]
LANGUAGES: tuple[Language, ...] = ("en", "de")

TEXTS: dict[str, tuple[str, str]] = {
    "title": ("guided calibration", "geführte Kalibrierung"),
    "skip": ("To the content", "Zum Inhalt"),
    "stages": ("Stages", "Schritte"),
    "machine": ("Machine", "Maschine"),
    "plan": ("Plan", "Plan"),
    "program": ("Program", "Programm"),
    "data": ("Data", "Daten"),
    "result": ("Result", "Ergebnis"),
    "use": ("Use", "Nutzen"),
    "state_done": ("done", "fertig"),
    "state_open": ("to do", "zu tun"),
    "state_stale": ("out of date", "veraltet"),
    "state_closed": ("not yet", "noch nicht"),
    "folder": ("Folder", "Ordner"),
    "language": ("Deutsch", "English"),
    "other_machine": ("Another machine", "Andere Maschine"),
    "command": ("The same in a terminal", "Dasselbe im Terminal"),
    "next": ("Next", "Weiter"),
    "waiting": ("waits until another command has ended", "wartet, bis ein anderer Befehl beendet ist"),
    "running": ("under way", "läuft"),
    "stopping": ("is ending", "wird beendet"),
    "done": ("done", "fertig"),
    "failed": ("refused", "abgelehnt"),
    "stopped": ("stopped; nothing was written", "angehalten; nichts wurde geschrieben"),
    "stop_search": ("Stop and keep the best", "Anhalten und das Beste behalten"),
    "stop": ("Stop", "Anhalten"),
    "give_up": ("Give up", "Abbrechen"),
    "seconds": ("s", "s"),
    "best_curve": ("best until now, over time", "bisher Bestes über der Zeit"),
    "stale": (
        "Out of date: the machine was changed since. {what}",
        "Veraltet: Die Maschine wurde seither geändert. {what}",
    ),
    "nothing_here": ("Nothing here yet.", "Noch nichts da."),
    # machine
    "which_machine": ("Which machine?", "Welche Maschine?"),
    "own_machines": ("Your machines in this folder", "Ihre Maschinen in diesem Ordner"),
    "built_in": ("Built in, to try it", "Eingebaut, zum Ausprobieren"),
    "built_in_note": (
        "Their sensors are simulated; all stages can be tried without a machine.",
        "Ihre Sensoren sind simuliert; alle Schritte lassen sich ohne Maschine ausprobieren.",
    ),
    "new_machine": ("A machine of your own", "Eine eigene Maschine"),
    "new_name": (
        "Name: small letters, digits and underscores, a letter first",
        "Name: Kleinbuchstaben, Ziffern und Unterstriche, ein Buchstabe zuerst",
    ),
    "begin_like": (
        "Begin from the machine that is most like it; you replace its values by those of your drawing",
        "Mit der ähnlichsten Maschine beginnen; ihre Werte ersetzen Sie durch die Ihrer Zeichnung",
    ),
    "begin_urdf": ("or from a URDF file of a robot", "oder mit der URDF-Datei eines Roboters"),
    "flange": (
        "Link of the URDF that carries the sensor, such as tool0",
        "Glied der URDF, das den Sensor trägt, etwa tool0",
    ),
    "make": ("Make it", "Anlegen"),
    "setup": ("Setup", "Aufbau"),
    "problem": ("This case cannot be read", "Diese Maschine ist nicht lesbar"),
    "from_above": ("from above, mm", "von oben, mm"),
    "from_side": ("from the side, mm", "von der Seite, mm"),
    "strut_lengths": (
        "Strut lengths at home in mm: compare them with the control's display",
        "Strebenlängen in der Grundstellung in mm: mit der Anzeige der Steuerung vergleichen",
    ),
    "values": ("Values", "Werte"),
    "values_note": (
        "Keys carry units. The picture follows while you type; nothing is written before you save.",
        "Die Schlüssel nennen die Einheit. Das Bild folgt der Eingabe; geschrieben wird erst beim Speichern.",
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
    "proposal": (
        "This box is within reach as a whole; its values are for limits.motion below.",
        "Dieser Bereich ist ganz erreichbar; seine Werte gehören unten in limits.motion.",
    ),
    "no_picture": ("There is no picture of this machine: {why}", "Von dieser Maschine gibt es kein Bild: {why}"),
    "template_value": ("still that of the example", "noch der Wert des Beispiels"),
    # plan
    "plan_lead": (
        "The motion that tells most about the machine, inside its limits.",
        "Die Bewegung, die am meisten über die Maschine verrät, in ihren Grenzen.",
    ),
    "cannot_plan": (
        "No motion can be planned for this machine; the case lacks: {what}. A recording can still be read.",
        "Für diese Maschine ist keine Bewegung planbar; es fehlt: {what}. Eine Aufzeichnung lässt sich lesen.",
    ),
    "motion_seconds": ("Seconds of the motion", "Sekunden der Bewegung"),
    "target_accuracy": (
        "Accuracy wanted, if any: the shortest motion that reaches it is found, up to the seconds above",
        "Gewünschte Genauigkeit, falls nötig: Gesucht wird die kürzeste Bewegung dafür, bis zu den Sekunden oben",
    ),
    "mass_deviation": ("Predicted standard deviation of the mass", "Vorhergesagte Standardabweichung der Masse"),
    "search_how": ("How long to search", "Wie lange suchen"),
    "quick": ("quick, 20 s", "schnell, 20 s"),
    "minute": ("a minute", "eine Minute"),
    "thorough": ("thorough, as long as it pays", "gründlich, solange es sich lohnt"),
    "family": ("Kind of motion", "Art der Bewegung"),
    "family_best": ("the best by trying", "die beste durch Probieren"),
    "family_ptp": ("moves from point to point", "Bewegungen von Punkt zu Punkt"),
    "family_spline": ("a smooth path", "eine glatte Bahn"),
    "family_fourier": ("oscillations", "Schwingungen"),
    "family_manual": ("by hand, to compare with", "von Hand, zum Vergleich"),
    "family_poses": ("poses to stand still at", "Posen zum Stillstehen"),
    "pose_count": ("Number of poses, for standing still only", "Anzahl der Posen, nur zum Stillstehen"),
    "for_controller": ("For the controller", "Für die Steuerung"),
    "any_controller": ("as the case says", "wie die Maschine es sagt"),
    "without_jerk": (
        "The machine bears steps of acceleration (needed for LinuxCNC and URScript)",
        "Die Maschine verträgt Beschleunigungssprünge (für LinuxCNC und URScript nötig)",
    ),
    "search": ("Search", "Suchen"),
    "plans": ("Plans", "Pläne"),
    "efficiency": (
        "Information, as a share of what no motion in these limits can exceed",
        "Information, als Anteil dessen, was keine Bewegung in diesen Grenzen übertrifft",
    ),
    "predicted": (
        "Predicted standard deviation of each parameter",
        "Vorhergesagte Standardabweichung jedes Parameters",
    ),
    "parameter": ("parameter", "Parameter"),
    "limit": ("limit", "Grenze"),
    "used": ("used", "genutzt"),
    "limits": ("What the machine's limits are used to", "Wie weit die Grenzen der Maschine genutzt werden"),
    "report": ("The whole report", "Der ganze Bericht"),
    "interrupted": ("search was stopped; the best until then", "Suche angehalten; das bis dahin Beste"),
    # program
    "program_lead": (
        "The plan in the controller's language, read back by other code and proven before it is written.",
        "Der Plan in der Sprache der Steuerung, von anderem Code zurückgelesen und bewiesen, bevor er entsteht.",
    ),
    "which_plan": ("Plan", "Plan"),
    "controller": ("Controller", "Steuerung"),
    "speed": ("Speed", "Tempo"),
    "full_speed": ("as planned", "wie geplant"),
    "slow": ("a tenth, to watch the first run", "ein Zehntel, um den ersten Lauf zu beobachten"),
    "write": ("Write and prove", "Schreiben und beweisen"),
    "programs": ("Programs", "Programme"),
    "download": ("Download", "Herunterladen"),
    "text": ("Text", "Text"),
    "text_cut": ("The beginning; the download has all of it.", "Der Anfang; die Datei enthält alles."),
    "answer_for": (
        "Limits that this controller does not enforce, and that you answer for",
        "Grenzen, die diese Steuerung nicht einhält und für die Sie einstehen",
    ),
    "exceeded": ("Exceeded", "Überschritten"),
    "line": ("line", "Zeile"),
    "checklist": ("At the machine", "An der Maschine"),
    "step_home": (
        "Jog the machine home: the program begins there.",
        "Die Maschine in die Grundstellung fahren: Dort beginnt das Programm.",
    ),
    "step_override": (
        "Keep the feed override at 100 % at most, a finger on feed hold.",
        "Vorschub-Override höchstens 100 %, ein Finger auf Vorschub-Halt.",
    ),
    "step_slow": (
        "Run the slow program first, and watch it to its end.",
        "Zuerst das langsame Programm fahren und bis zum Ende beobachten.",
    ),
    "step_record": (
        "Start the recorder: forces, struts or joints, and the trigger, 500 Hz or more.",
        "Aufzeichnung starten: Kräfte, Streben oder Gelenke und Trigger, mindestens 500 Hz.",
    ),
    "step_run": ("Run the program, then stop the recorder.", "Das Programm fahren, dann die Aufzeichnung beenden."),
    "step_bring": ("Bring the file to the next stage.", "Die Datei in den nächsten Schritt bringen."),
    # data
    "data_lead": (
        "The recorded run, as the recorder wrote it: any file of text, LVM, SINUMERIK XML, Parquet or a ROS bag.",
        "Der aufgezeichnete Lauf, wie ihn der Rekorder schrieb: Text, LVM, SINUMERIK-XML, Parquet oder ROS-Bag.",
    ),
    "drop": ("Drop a file here, or choose one", "Eine Datei hier ablegen oder wählen"),
    "drop_limit": ("at most 2 GB; it stays in the folder", "höchstens 2 GB; sie bleibt im Ordner"),
    "uploading": ("copying", "wird kopiert"),
    "too_large": ("The file is larger than 2 GB.", "Die Datei ist größer als 2 GB."),
    "rehearse": ("Rehearse instead", "Stattdessen proben"),
    "rehearse_note": (
        "Executes the program on a controller of this computer; sensors and encoders are simulated.",
        "Führt das Programm auf einer Steuerung dieses Rechners aus; Sensoren und Geber sind simuliert.",
    ),
    "virtual": ("built-in virtual controller", "eingebaute virtuelle Steuerung"),
    "run_it": ("Rehearse", "Proben"),
    "cannot_run": ("It cannot be rehearsed; the case lacks: {what}", "Proben geht nicht; es fehlt: {what}"),
    "no_program": ("Write a program first.", "Zuerst ein Programm schreiben."),
    "not_in_case": ("The case does not have them yet.", "Die Maschine hat sie noch nicht."),
    "unit_forces": ("forces", "Kräfte"),
    "unit_moments": ("moments", "Momente"),
    "unit_struts": ("strut lengths", "Strebenlängen"),
    "unit_angles": ("angles", "Winkel"),
    "recordings": ("Recordings", "Aufzeichnungen"),
    "simulated": ("rehearsal, simulated", "Probe, simuliert"),
    "recorded": ("file", "Datei"),
    "look": ("How is it read?", "Wie wird sie gelesen?"),
    "look_first": (
        "Ask first how the file is read, then compare with what you know.",
        "Zuerst fragen, wie die Datei gelesen wird, dann vergleichen.",
    ),
    "reads": ("The file is read with these settings.", "Mit diesen Einstellungen wird die Datei gelesen."),
    "reads_not": ("The file is not read yet.", "Die Datei wird noch nicht gelesen."),
    "doubts": ("To be compared or completed", "Zu vergleichen oder zu ergänzen"),
    "columns": ("What each channel is", "Was jeder Kanal ist"),
    "channel": ("hexcite needs", "hexcite braucht"),
    "in_file": ("column of the file", "Spalte der Datei"),
    "unit": ("unit", "Einheit"),
    "guessed": ("a guess, by its values", "eine Vermutung nach den Werten"),
    "none": ("none", "keine"),
    "as_labelled": ("as the file says", "wie die Datei sagt"),
    "take_proposal": ("Take the proposal into the case", "Vorschlag in die Maschine übernehmen"),
    "take_menus": ("Take these menus into the case, and look again", "Diese Menüs übernehmen und neu lesen"),
    "own_only": (
        "This is a built-in machine, whose way of reading stays. Begin your own from it, on the first stage.",
        "Dies ist eine eingebaute Maschine, deren Leseweise bleibt. Im ersten Schritt eine eigene damit beginnen.",
    ),
    "identify": ("Identify the parameters", "Parameter bestimmen"),
    "picture": ("Channels over time", "Kanäle über der Zeit"),
    # result
    "result_lead": (
        "What the run says, and how far to trust it.",
        "Was der Lauf sagt, und wie weit man ihm trauen kann.",
    ),
    "results": ("Results", "Ergebnisse"),
    "verdict_good": ("Nothing speaks against this run.", "Nichts spricht gegen diesen Lauf."),
    "verdict_doubt": ("Look at this before you use the values", "Vor der Nutzung der Werte ansehen"),
    "verdict_counted": ("Usable: the deviations allow for this", "Nutzbar: Die Abweichungen berücksichtigen dies"),
    "verdict_simulated": ("A rehearsal: sensors were simulated.", "Eine Probe: Die Sensoren waren simuliert."),
    "more_findings": ("Further findings", "Weitere Befunde"),
    "to_menus": ("Change how the recording is read", "Ändern, wie die Aufzeichnung gelesen wird"),
    "value": ("value", "Wert"),
    "deviation": ("±", "±"),
    "deviation_note": (
        "± is one standard deviation: the larger of that for white noise and the robust one.",
        "± ist eine Standardabweichung: die größere aus der für weißes Rauschen und der robusten.",
    ),
    "not_counted": (
        "Not counted, for the case states no tolerances: {what}.",
        "Nicht enthalten, da die Maschine keine Toleranzen nennt: {what}.",
    ),
    "given": ("given", "gegeben"),
    "pool": (
        "Several runs together: one estimate, and whether they agree",
        "Mehrere Läufe zusammen: eine Schätzung, und ob sie übereinstimmen",
    ),
    "pool_do": ("Pool the chosen results", "Gewählte Ergebnisse zusammenfassen"),
    # use
    "use_lead": (
        "The calibrated model where it is needed. A preview writes nothing.",
        "Das kalibrierte Modell dort, wo es gebraucht wird. Eine Vorschau schreibt nichts.",
    ),
    "export": ("Export", "Exportieren"),
    "target": ("Target", "Ziel"),
    "preview": ("Preview", "Vorschau"),
    "in_spite": (
        "in spite of warnings, which are written into the file",
        "trotz Warnungen, die in die Datei geschrieben werden",
    ),
    "written": ("Written: {what}", "Geschrieben: {what}"),
    "force": ("Force of another recording", "Kraft einer anderen Aufzeichnung"),
    "force_do": ("Compute external force and moment", "Äußere Kraft und Moment berechnen"),
    "recording": ("Recording", "Aufzeichnung"),
    "tare": ("New offsets from a standstill", "Neue Nullpunkte aus einem Stillstand"),
    "tare_do": ("Identify the offsets anew", "Nullpunkte neu bestimmen"),
    "payload": ("Payload: mounted less not mounted", "Nutzlast: montiert minus nicht montiert"),
    "payload_do": ("Compute the payload", "Nutzlast berechnen"),
    "without_payload": ("Result without it", "Ergebnis ohne sie"),
    "with_payload": ("Result with it", "Ergebnis mit ihr"),
    "rms": ("rms", "Effektivwert"),
    "peak": ("peak", "Spitze"),
    "lost": ("The page has no such place.", "Diese Seite gibt es nicht."),
    "to_begin": ("To the machines", "Zu den Maschinen"),
    "connection_lost": (
        "The server does not answer. Start hexcite page again; nothing that was finished is lost.",
        "Der Server antwortet nicht. hexcite page neu starten; nichts Fertiges ist verloren.",
    ),
}
"""Key -> English, German."""


def text(key: str, language: Language, **values: object) -> str:
    """A text of the page, with values in its places; raises KeyError for a key that there is not."""
    found = TEXTS[key][LANGUAGES.index(language)]
    return found.format(**values) if values else found


def language_of(accepted: str) -> Language:
    """The first of our languages that a browser accepts, by its header; English where it is none of them."""
    ranked = []
    for k, part in enumerate(accepted.lower().split(",")[:20]):
        name, _, quality = part.strip().partition(";q=")
        try:
            rank = -float(quality or 1.0)
        except ValueError:
            continue
        ranked.append((rank, k, name.split("-")[0]))
    return next((own for _, _, name in sorted(ranked) for own in LANGUAGES if own == name), "en")
