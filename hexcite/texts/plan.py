"""Words of the stage Plan: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
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
    "known_results": (
        "Earlier results of the same load that count as known: deviations are then of all together",
        "Frühere Ergebnisse derselben Last, die als bekannt gelten: Abweichungen gelten dann für alle zusammen",
    ),
    "kinds": ("Which kind, and why", "Welche Art, und warum"),
    "kind_why": ("why", "warum"),
    "why_ptp": (
        "Every controller times such moves by itself, and the program is short.",
        "Jede Steuerung fährt solche Bewegungen mit ihren eigenen Rampen; das Programm ist kurz.",
    ),
    "why_spline": (
        "Carries most where jerk is limited; needs a controller that follows splines or a dense path.",
        "Verrät am meisten, wo der Ruck begrenzt ist; die Steuerung muss Splines oder dichten Bahnen folgen.",
    ),
    "why_fourier": (
        "Known frequencies, without any corner; needs a controller that follows a dense path.",
        "Bekannte Frequenzen ohne Ecken; die Steuerung muss einer dichten Bahn folgen.",
    ),
    "why_manual": (
        "What people drive without a search; it is planned beside each search, to compare with.",
        "Was man ohne Suche fährt; wird neben jeder Suche geplant, zum Vergleich.",
    ),
    "why_poses": (
        "Mass, centre of gravity and offsets without any dynamics; no inertia. For machines that move slowly.",
        "Masse, Schwerpunkt und Nullpunkte ohne Dynamik, ohne Trägheit. Für langsame Maschinen.",
    ),
    "by_hand_runs": ("The motion by hand is being planned.", "Die Bewegung von Hand wird geplant."),
    "by_hand_not": ("There is no motion by hand:", "Es gibt keine Bewegung von Hand:"),
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
    "moving": ("The machine along the plan", "Die Maschine entlang des Plans"),
    "moving_note": (
        "A limit lights up where the motion uses it to its end.",
        "Eine Grenze leuchtet auf, wo die Bewegung sie ganz ausnutzt.",
    ),
    "report": ("The whole report", "Der ganze Bericht"),
    "interrupted": ("search was stopped; the best until then", "Suche angehalten; das bis dahin Beste"),
}
