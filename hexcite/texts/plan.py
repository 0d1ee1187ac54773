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
    "search_again": ("Another search", "Weitere Suche"),
    "motion_seconds": ("Seconds of the motion", "Sekunden der Bewegung"),
    "seconds_usual": (
        "5 to 30 are usual; longer motions give smaller deviations",
        "üblich sind 5 bis 30; längere Bewegungen geben kleinere Abweichungen",
    ),
    "target_accuracy": (
        "Accuracy wanted, if any: the shortest motion that reaches it is found, up to the seconds above",
        "Gewünschte Genauigkeit, falls nötig: Gesucht wird die kürzeste Bewegung dafür, bis zu den Sekunden oben",
    ),
    "target_how": (
        "standard deviations with units: m is the mass, xC yC zC the centre of gravity",
        "Standardabweichungen mit Einheit: m ist die Masse, xC yC zC der Schwerpunkt",
    ),
    "target_example": ("m=5g, zC=0.05mm", "m=5g; zC=0,05mm"),
    "mass_deviation": ("Predicted standard deviation of the mass", "Vorhergesagte Standardabweichung der Masse"),
    "search_how": ("How long to search", "Wie lange suchen"),
    "quick": (
        "quick: 20 s of search, then the proof and the report",
        "schnell: 20 s Suche, dann Beweis und Bericht",
    ),
    "minute": ("a minute of search", "eine Minute Suche"),
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
    "for_controller_note": (
        "only where it times moves by itself; the program is written in the next stage",
        "nur, wenn sie Bewegungen selbst ihre Zeit gibt; das Programm entsteht im nächsten Schritt",
    ),
    "any_controller": ("any of the machine", "jede der Maschine"),
    "without_jerk": (
        "Acceleration may change in steps, without a limit of jerk (LinuxCNC and URScript need this)",
        "Die Beschleunigung darf springen, ohne Grenze des Rucks (LinuxCNC und URScript brauchen das)",
    ),
    "seed": ("Another start of the search (seed)", "Anderer Beginn der Suche (Startzahl)"),
    "seed_note": (
        "any whole number: each leads to other random starts",
        "eine ganze Zahl: jede führt zu anderen zufälligen Starts",
    ),
    "information": ("information", "Information"),
    "made_for": ("for {what}", "für {what}"),
    "better_plan": (
        "An earlier plan that was asked for alike tells more (information {efficiency}):",
        "Ein früherer Plan mit denselben Vorgaben verrät mehr (Information {efficiency}):",
    ),
    "efficiency_note": (
        "The search makes the information on all parameters together as large as it can. 1 is a bound that no motion "
        "reaches; what is usual depends on the machine (0.1 to 0.7): compare with the motion by hand. Where one "
        "parameter counts, such as the mass, search with the accuracy wanted.",
        "Die Suche macht die Information über alle Parameter zusammen so groß, wie sie kann. 1 ist eine Schranke, die "
        "keine Bewegung erreicht; was üblich ist, hängt von der Maschine ab (0.1 bis 0.7): mit der Bewegung von Hand "
        "vergleichen. Zählt ein Parameter, etwa die Masse, mit der gewünschten Genauigkeit suchen.",
    ),
    "best_note": (
        "The smallest deviation of each row is bold. A motion with more information in all may measure a single "
        "parameter less well than another one.",
        "Die kleinste Abweichung jeder Zeile ist fett. Eine Bewegung mit insgesamt mehr Information kann einen "
        "einzelnen Parameter weniger genau bestimmen als eine andere.",
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
