"""Words of the stage Use: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
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
