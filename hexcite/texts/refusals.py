"""What the page itself refuses: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
    "ini_includes": (
        "includes files that are not beside it; bring them all, or compare it in a terminal by --ini",
        "bindet Dateien ein, die nicht daneben liegen; alle bringen oder im Terminal mit --ini vergleichen",
    ),
    "no_line": ("is too long, or has control characters", "ist zu lang oder enthält Steuerzeichen"),
    "built_in_stays": ("a built-in case is not changed", "eine eingebaute Maschine bleibt, wie sie ist"),
    "look_at_it_first": ("look at it first", "zuerst fragen, wie sie gelesen wird"),
    "no_such_remedy": (
        "there is no remedy of this number any more; identify again",
        "diesen Vorschlag gibt es nicht mehr; die Parameter neu bestimmen",
    ),
    "other_remedy": (
        "it was identified again meanwhile; look at the stage anew",
        "inzwischen wurde neu bestimmt; die Seite neu ansehen",
    ),
    "no_proposal": (
        "there is no proposal for this machine; look for the largest reachable box first",
        "für diese Maschine gibt es keinen Vorschlag; zuerst den größten erreichbaren Bereich suchen",
    ),
    "no_machine_name": ("{name!r} is not a name of a machine", "{name!r} ist kein Name einer Maschine"),
    "too_few_results": ("choose two or more results to pool", "zwei oder mehr Ergebnisse wählen"),
    "no_results": ("there are no results yet", "es gibt noch keine Ergebnisse"),
    "no_such_value": ("there is no such value", "diesen Wert gibt es nicht"),
    "no_true_or_false": ("{text!r} is not true or false", "{text!r} ist weder true noch false"),
    "no_list": (
        "{text!r} is not a list of numbers; write 0, 120, 240 or ±60, and with decimal commas 0,5; 120,5; 240,5",
        "{text!r} ist keine Liste von Zahlen; 0; 120; 240 oder ±60 schreiben, mit Dezimalkommas 0,5; 120,5; 240,5",
    ),
    "no_number": ("{text!r} is not a number", "{text!r} ist keine Zahl"),
    "no_number_between": (
        "{text!r} is not a number from {low:g} to {high:g}",
        "{text!r} ist keine Zahl von {low:g} bis {high:g}",
    ),
    "no_whole_number": ("{text!r} is not a whole number", "{text!r} ist keine ganze Zahl"),
    "is_program": (
        "{name} is a program that hexcite wrote, and not a recording: run it at the machine, or rehearse it, and bring "
        "what the control recorded meanwhile",
        "{name} ist ein Programm, das hexcite geschrieben hat, und keine Aufzeichnung: an der Maschine ausführen oder "
        "proben und bringen, was die Steuerung dabei aufgezeichnet hat",
    ),
    "not_for_linuxcnc": (
        "{name} is not a program for LinuxCNC; rehearse it on the virtual controller, or write one for LinuxCNC",
        "{name} ist kein Programm für LinuxCNC; auf der virtuellen Steuerung proben, oder eines für LinuxCNC schreiben",
    ),
    "no_choice": ("{text!r} is not a choice", "{text!r} steht nicht zur Wahl"),
    "no_column": ("{text!r} is not a column of the file", "{text!r} ist keine Spalte der Datei"),
    "column_is_read": (
        "the file has a column of this name, which is read; choose that or another one",
        "die Datei hat eine Spalte dieses Namens, die gelesen wird; diese oder eine andere wählen",
    ),
    "chosen_twice": (
        "{name!r} is chosen twice; a column is one channel",
        "{name!r} ist zweimal gewählt; eine Spalte ist ein Kanal",
    ),
}
