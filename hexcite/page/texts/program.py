"""Words of the stage Program: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
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
    "worst_of_lines": (
        "Beside a line: its worst limit. Where the program itself states the times, only lines in which a limit comes "
        "closest have one. It is shown for a program that was written since the page was started.",
        "Neben einer Zeile: ihre am meisten genutzte Grenze. Wo das Programm selbst die Zeiten vorgibt, nur neben "
        "Zeilen, in denen eine Grenze am nächsten ist. Gezeigt, wenn das Programm seit dem Start der Seite entstand.",
    ),
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
}
