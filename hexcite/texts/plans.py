"""German for notes on plans, by code."""

PLANS = {
    "order_1": "Ordnung 1 bewegt sich auf Ellipsen: Beschleunigungen sind -w^2 mal der Weg von der Mitte, alle bei "
    "einer Frequenz; nur die Wege hinein und heraus, und die Schwerkraft beim Drehen, unterscheiden Trägheit von "
    "Nullpunkten und von Fehlern, die von der Pose abhängen; auch Ordnung 3 planen und die vorausgesagten "
    "Abweichungen vergleichen",
    "only_start": "der einzige Start",
    "best_start": "der beste von {count} Starts",
    "not_converged": "{which} war nicht am Ziel ({why}): wo keine Zahl von Starts verlangt ist, geht die Suche weiter, "
    "bis weitere Starts wenig bringen",
    "at_iterations": "an der Grenze der Iterationen",
    "search_stopped": "durch Zeitgrenze oder Ctrl-C beendet",
    "converged": "am Ziel",
    "short_steps": "seine Schritte wurden zu kurz",
    "drawn_back": "die gefundene Bewegung überschritt eine Grenze und wurde auf {share} % ihrer Wege verkleinert, was "
    "Information kostet: mit anderer Startzahl planen, oder in einem kleineren Bereich",
    "short_ways": "keine Grenze von Geschwindigkeit oder Kraft ist über {share} % genutzt ({limit}): die Wege sind "
    "kurz für diese Geschwindigkeiten; [limits.motion] weiter angeben, oder {other} versuchen",
    "ended_as_asked": "nach {seconds} s beendet, wie verlangt: die beste von {count} Bewegungen bis dahin",
    "best_of_starts": "der beste von {count} Starts, der nächste hat {loss} % weniger Information: mehr Starts bringen "
    "wenig",
    "family_has": "{family} {efficiency}",
    "less_moves": "weniger Bewegungen",
    "free_period": "eine freie Periode",
    "moves_instead": "Bewegungen von Punkt zu Punkt",
    "timed_moves": "; für eine Steuerung, die Bewegungen selbst ihre Zeit gibt, Bewegungen von Punkt zu Punkt wählen",
    "by_trying": "{family}, durch Probieren: D-Effizienz {most}, und die ersten Starts anderer: {behind}{path}",
    "needless_harmonics": "Oberschwingungen über {order} sind unnötig: ohne sie behält die Bewegung {share} % ihrer "
    "Information; Ordnung {order} sucht weniger Unbekannte",
    "whole_periods": "ganze Perioden von {period} s brauchen {taken} s der {duration} s; {more} s hätten Zeit für "
    "eine mehr",
    "known_not_counted": "was durch {named} bekannt war, zählt nicht mit: Der Plan wurde aus seinem Ordner gelesen, "
    "der es nicht enthält",
    "jerk_left_out": "gemacht für {controller}, das den Ruck nicht begrenzt: Beschleunigungen springen, und die "
    "Grenzen des Rucks der Maschine ({limits}) sind weggelassen, wie verlangt",
    "with_jerk": "mit begrenztem Ruck brauchen dieselben Bewegungen {seconds} s, mit einer D-Effizienz von "
    "{efficiency}",
    "best_moves": "{moves} Bewegungen verraten am meisten; versucht wurden {tried}",
    "best_order": "Ordnung {order} mit Periode {period} s ist das Beste von Suchen, die bei {count} Paaren von Ordnung "
    "und Periode begannen",
    "shortest": "{duration} s ist die kürzeste von {count} Dauern, die {targets} erreicht: vorausgesagt ist "
    "{predicted}",
    "shorter_none": "{words}; für {duration} s gibt es keine Bewegung",
    "shorter_predicts": "{words}; {duration} s sagt {predicted} voraus",
}
"""Why a plan was chosen, and why another would be better."""
