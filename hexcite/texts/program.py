"""Words of the stage Program: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
    "program_lead": (
        "The plan in the controller's language, read back by other code and proven before it is written.",
        "Der Plan in der Sprache der Steuerung, von anderem Code zurückgelesen und bewiesen, bevor er entsteht.",
    ),
    "which_plan": ("Plan", "Plan"),
    "controller": ("Controller", "Steuerung"),
    "form": ("Form of a program for ROS 2", "Form eines Programms für ROS 2"),
    "form_yaml": ("YAML, for ros2 topic pub", "YAML, für ros2 topic pub"),
    "form_json": ("JSON, for programs of your own", "JSON, für eigene Programme"),
    "form_py": ("a script that compares the place and sends it", "ein Skript, das den Ort vergleicht und sendet"),
    "ini": (
        "INI file of the LinuxCNC machine: its planner and limits are to be those of the case",
        "INI-Datei der LinuxCNC-Maschine: Ihr Planer und ihre Grenzen sollen die der Maschine sein",
    ),
    "ini_about": (
        "LinuxCNC: compare with the INI file of the machine",
        "LinuxCNC: mit der INI-Datei der Maschine vergleichen",
    ),
    "ini_run": (
        "For LinuxCNC: the INI file of the machine, whose planner and limits are compared",
        "Für LinuxCNC: die INI-Datei der Maschine, mit deren Planer und Grenzen verglichen wird",
    ),
    "ini_none": ("not compared", "nicht verglichen"),
    "ini_bring": ("Bring an INI file", "Eine INI-Datei bringen"),
    "speed": ("Speed", "Tempo"),
    "full_speed": ("as planned", "wie geplant"),
    "slow": ("a tenth, to watch the first run", "ein Zehntel, um den ersten Lauf zu beobachten"),
    "write": ("Write and prove", "Schreiben und beweisen"),
    "programs": ("Programs", "Programme"),
    "download_file": ("Download {file}", "{file} herunterladen"),
    "download": ("Download", "Herunterladen"),
    "text": ("Text", "Text"),
    "text_cut": ("The beginning; the download has all of it.", "Der Anfang; die Datei enthält alles."),
    "answer_for": (
        "Limits that this controller does not enforce, and that you answer for",
        "Grenzen, die diese Steuerung nicht einhält und für die Sie einstehen",
    ),
    "exceeded": ("Exceeded", "Überschritten"),
    "line": ("line", "Zeile"),
    "proven": ("Proven, and written.", "Bewiesen und geschrieben."),
    "verdict_without": ("Left out as planned: {what}.", "Wie geplant weggelassen: {what}."),
    "verdict_enforces": ("The controller ({dialect}) enforces: {what}.", "Die Steuerung ({dialect}) hält ein: {what}."),
    "verdict_nobody": ("Nobody enforces: {what}.", "Niemand hält ein: {what}."),
    "verdict_beyond": ("Exceeded, and nobody enforces: {what}.", "Überschritten, und niemand hält ein: {what}."),
    "add_settings": ("Add settings of {control}", "Einstellungen von {control} hinzufügen"),
    "without_settings": (
        "What is added are usual values, as a beginning: compare them with what the builder of the machine says.",
        "Hinzugefügt werden übliche Werte als Anfang: mit den Angaben des Herstellers der Maschine vergleichen.",
    ),
    "see_settings": ("Settings of the controllers", "Einstellungen der Steuerungen"),
    "verdict_settings": (
        "What the controller enforces, it enforces by its own settings of axes and drives: they must be no larger than "
        "the limits of the case.",
        "Was die Steuerung einhält, hält sie nach ihren eigenen Einstellungen von Achsen und Antrieben ein: Diese "
        "dürfen nicht größer sein als die Grenzen der Maschine hier.",
    ),
    "verdict_more": (
        "Without that, the motion would come to {what}.",
        "Ohne das käme die Bewegung auf {what}.",
    ),
    "worst_of_lines": (
        "Beside a line: its worst limit. Where the program itself states the times, only lines in which a limit comes "
        "closest have one. It is shown for the program that this page wrote last.",
        "Neben einer Zeile: ihre am meisten genutzte Grenze. Wo das Programm selbst die Zeiten vorgibt, nur neben "
        "Zeilen, in denen eine Grenze am nächsten ist. Gezeigt für das Programm, das diese Seite zuletzt schrieb.",
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
    "step_stop": (
        "Keep a finger on the emergency stop.",
        "Einen Finger auf Not-Halt.",
    ),
    "step_slow": (
        "For a first try write the program above at a tenth of its speed too, run that one, and watch it to its end.",
        "Für den ersten Versuch oben auch das Programm mit einem Zehntel der Geschwindigkeit schreiben, es fahren und "
        "bis zum Ende beobachten.",
    ),
    "step_watch": (
        "This is the slow program: run it, and watch it to its end. It is not recorded.",
        "Das ist das langsame Programm: es fahren und bis zum Ende beobachten. Es wird nicht aufgezeichnet.",
    ),
    "of_plan": ("of the plan {plan}", "zum Plan {plan}"),
    "step_record": (
        "Start the recorder, as below: forces, struts or joints, and the trigger.",
        "Aufzeichnung starten, wie unten: Kräfte, Streben oder Gelenke und Trigger.",
    ),
    "step_run": ("Run the program, then stop the recorder.", "Das Programm fahren, dann die Aufzeichnung beenden."),
    "step_bring": (
        "Bring the recording to the stage Data.",
        "Die Aufzeichnung in den Schritt Daten bringen.",
    ),
    "record_here": ("How to record on this control", "So wird an dieser Steuerung aufgezeichnet"),
    "record_what": (
        "These channels at {rate} Hz, about {seconds} s, from before the motion to after it, into {file}:",
        "Diese Kanäle mit {rate} Hz, rund {seconds} s, von vor der Bewegung bis danach, in die Datei {file}:",
    ),
    "rec_hal_load": (
        "Put the HAL lines below into a file of the configuration, or type them in halcmd.",
        "Die HAL-Zeilen unten in eine Datei der Konfiguration schreiben oder in halcmd tippen.",
    ),
    "rec_hal_forces": (
        "Replace YOUR_FORCE by the pins of your force channels. The trigger is output 0, which the program switches.",
        "YOUR_FORCE durch die Pins Ihrer Kraftkanäle ersetzen. Der Trigger ist Ausgang 0, den das Programm schaltet.",
    ),
    "rec_hal_run": (
        "Start the last line in a terminal, then the program. Afterwards sampler.0.overruns must be 0.",
        "Die letzte Zeile im Terminal starten, dann das Programm. Danach muss sampler.0.overruns 0 sein.",
    ),
    "rec_trace_session": (
        "Operating area Diagnostics, Trace, new session: in the window Select variables for trace insert the actual "
        "position of each drive (such as $VA_IM of its machine axis), each force (such as $A_INA of its analogue "
        "input) and, as trigger, {trigger}.",
        "Bedienbereich Diagnose, Trace, neue Sitzung: im Fenster zur Auswahl der Variablen die Istposition jedes "
        "Antriebs (etwa $VA_IM seiner Maschinenachse), jede Kraft (etwa $A_INA ihres Analogeingangs) und als Trigger "
        "{trigger} einfügen.",
    ),
    "rec_trace_armed": (
        "Choose $AN_SLTRACE as its start and stop trigger (1 starts it, 2 stops it), and arm it by the softkey "
        "Start trace before the program runs.",
        "$AN_SLTRACE als Start und Stopp wählen (1 startet, 2 beendet) und vor dem Programm mit dem Softkey "
        "Trace starten scharf schalten.",
    ),
    "rec_trace_by_hand": (
        "Softkey Start trace before the program, Stop trace after it.",
        "Softkey Trace starten vor dem Programm, Trace anhalten danach.",
    ),
    "rec_trace_save": (
        "Save the session as {file}; Operate writes XML, which is read as it is.",
        "Die Sitzung als {file} speichern; Operate schreibt XML, das so gelesen wird.",
    ),
    "rec_scope_channels": (
        "In Visual Studio, File, New, Project, TwinCAT Measurement, YT Scope Project. Right-click the axis in the "
        "Solution Explorer, Target Browser: choose actual positions of all axes (NcToPlc.ActPos), all forces, and the "
        "trigger. In their Properties, Acquisition: a sample time of {rate} Hz or more, the same for all.",
        "In Visual Studio: Datei, Neu, Projekt, TwinCAT Measurement, YT Scope Project. Im Solution Explorer rechts auf "
        "die Achse klicken, Target Browser: Istpositionen aller Achsen (NcToPlc.ActPos), alle Kräfte und den Trigger "
        "wählen. In ihren Properties, Acquisition: eine Abtastzeit von {rate} Hz oder mehr, für alle gleich.",
    ),
    "rec_scope_trigger": (
        "The trigger is a PLC variable that {trigger} switch on and off.",
        "Der Trigger ist eine SPS-Variable, die {trigger} ein- und ausschalten.",
    ),
    "rec_scope_export": (
        "Record before the program, Stop Record after it. Then Export, in the context menu of the Scope or in the menu "
        "Scope: all channels, CSV, {file}; Scale values before export on, Timelines = All, Marker Windows = None, "
        "Include Trigger-Infos off.",
        "Record vor dem Programm, Stop Record danach. Dann Export, im Kontextmenü des Scope oder im Menü Scope: alle "
        "Kanäle, CSV, {file}; Scale values before export an, Timelines = All, Marker Windows = None, "
        "Include Trigger-Infos aus.",
    ),
    "rec_rtde_file": (
        "Save the first part below as record_configuration.xml, beside record.py of Universal Robots' RTDE client.",
        "Den ersten Teil unten als record_configuration.xml neben record.py des RTDE-Clients speichern.",
    ),
    "rec_rtde_run": (
        "Start the last line, then the program, then Ctrl-C. The trigger is digital output {trigger}.",
        "Die letzte Zeile starten, dann das Programm, dann Strg-C. Der Trigger ist der digitale Ausgang {trigger}.",
    ),
    "rec_rtde_raw": (
        "ft_raw_wrench is in the sensor's axes; actual_TCP_force is compensated and turned, and no use. "
        "A sensor of another maker is recorded in place of it.",
        "ft_raw_wrench steht in den Achsen des Sensors; actual_TCP_force ist kompensiert, gedreht und unbrauchbar. "
        "Ein fremder Sensor wird stattdessen aufgezeichnet.",
    ),
    "rec_table_channels": (
        "The task that moves the machine through the table, a row a cycle, also records actual positions and raw "
        "forces, with names in the first row.",
        "Die Task, die die Maschine Zeile für Zeile durch die Tabelle führt, zeichnet im selben Takt Istpositionen und "
        "rohe Kräfte auf, Namen in der ersten Zeile.",
    ),
    "rec_table_trigger": (
        "The trigger is 1 as in the table's own column, and 0 before and after.",
        "Der Trigger ist 1 wie in der Spalte der Tabelle, davor und danach 0.",
    ),
    "rec_table_export": (
        "Write {file} with times in seconds and a point or comma as decimal sign.",
        "{file} mit Zeiten in Sekunden schreiben, Punkt oder Komma als Dezimalzeichen.",
    ),
    "rec_bag_run": (
        "Start the line below, then send the trajectory.",
        "Die Zeile unten starten, dann die Trajektorie senden.",
    ),
    "rec_bag_raw": (
        "The wrench must be the raw one in the sensor's frame; nothing compensated, zeroed or turned.",
        "Das Wrench-Topic muss das rohe im Sensorsystem sein; nichts kompensiert, genullt oder gedreht.",
    ),
    "rec_bag_stop": (
        "End it with Ctrl-C; bring the .db3 or .mcap file of the folder {file}.",
        "Mit Strg-C beenden; die .db3- oder .mcap-Datei des Ordners {file} mitbringen.",
    ),
}
