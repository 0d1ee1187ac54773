"""Words of the stage Result: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
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
}
