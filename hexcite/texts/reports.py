"""German words of reports: texts that stand on a page as they are, by their English, and sentences by their codes."""

from collections.abc import Mapping

_AXES = {"translation": "Translation", "rotation": "Rotation"}
_MOTION = {"Position from home": "Position von der Grundstellung aus", "Velocity": "Geschwindigkeit"} | {
    "Acceleration": "Beschleunigung"
}
_WORDS = {
    # headings
    "External force": "Äußere Kraft",
    "Payload": "Nutzlast",
    "History": "Verlauf",
    "Inputs and versions": "Eingaben und Versionen",
    "What the plan promises": "Was der Plan verspricht",
    "Which parameters can be told apart": "Welche Parameter sich unterscheiden lassen",
    "The machine along the plan": "Die Maschine entlang des Plans",
    "How close it comes to each limit": "Wie nahe die Bewegung jeder Grenze kommt",
    "The motion and its limits": "Die Bewegung und ihre Grenzen",
    "Parameters with standard deviations": "Parameter mit Standardabweichungen",
    "The load at the robot's flange": "Die Last am Flansch des Roboters",
    "Treatment of the data beside the default": "Behandlung der Daten neben der üblichen",
    "Nearest body that can exist": "Nächster Körper, den es geben kann",
    "The runs, and how far they scatter": "Die Läufe, und wie weit sie streuen",
    "All models of the run (Table 3)": "Alle Modelle des Laufs (Tabelle 3)",
    "Forces and residuals": "Kräfte und Residuen",
    "Accelerations, planned and measured": "Beschleunigungen, geplant und gemessen",
    "Parameters that take each other's part": "Parameter, die füreinander eintreten",
    "Normal densities of the parameters (Table 5)": "Normalverteilungen der Parameter (Tabelle 5)",
    "How large": "Wie groß",
    "Over time": "Über der Zeit",
    "Results": "Ergebnisse",
    "What was added": "Was hinzukam",
    "In the frame that was asked for": "Im verlangten Koordinatensystem",
    "The two results": "Die beiden Ergebnisse",
    # facts and inputs
    "machine": "Maschine",
    "plan": "Plan",
    "program": "Programm",
    "recording": "Aufzeichnung",
    "page made": "Seite erstellt",
    "input": "Eingabe",
    "value": "Wert",
    "case": "Maschine",
    "criterion": "Kriterium",
    "model": "Modell",
    "origin": "Herkunft",
    "controller": "Steuerung",
    "seed": "Startwert des Zufalls",
    "payload": "Nutzlast",
    "simulation_source": "Quelle der Simulation",
    "program_hash": "Fingerabdruck des Programms",
    "plan_hash": "Fingerabdruck des Plans",
    "parameters": "Parameter",
    "left out": "weggelassen",
    "time 0": "Zeit 0",
    "result with it": "Ergebnis mit ihr",
    "result with the payload": "Ergebnis mit der Nutzlast",
    "result without the payload": "Ergebnis ohne die Nutzlast",
    "sensors and encoders are simulated": "Sensoren und Geber sind simuliert",
    "recorded on a machine": "an einer Maschine aufgezeichnet",
    "recorded on a machine: nothing says that it was simulated": (
        "an einer Maschine aufgezeichnet: Nichts sagt, dass es simuliert war"
    ),
    "virtual controller (exact on timed paths, built in)": "virtuelle Steuerung (genau auf Bahnen mit Zeiten, "
    "eingebaut)",
    # what is said in sentences
    "What the motion is, how precise its run will make the parameters, and how close it comes to each limit.": (
        "Was die Bewegung ist, wie genau ihr Lauf die Parameter macht, und wie nahe sie jeder Grenze kommt."
    ),
    "By the motion alone, without forces, all channels weighed alike. Models 0 to 9: Table 2; 10: model 3 with "
    "inertia. The condition is that of the scaled regressor (26).": (
        "Nach der Bewegung allein, ohne Kräfte, alle Kanäle gleich gewichtet. Modelle 0 bis 9: Tabelle 2; 10: Modell 3 "
        "mit Trägheit. Die Kondition ist die des skalierten Regressors (26)."
    ),
    "Squares of the parts add up to that of ±; tolerances are carried through to first order.": (
        "Die Quadrate der Anteile ergeben zusammen das von ±; Toleranzen sind in erster Ordnung fortgepflanzt."
    ),
    "Estimates are made without asking whether a body can have them; this one can, and keeps [bounds].": (
        "Geschätzt wird, ohne zu fragen, ob ein Körper das haben kann; dieser kann es und hält [bounds] ein."
    ),
    "Runs are compared by their own noise; tolerances of the case, which they have in common, count once.": (
        "Läufe werden nach ihrem eigenen Rauschen verglichen; Toleranzen der Maschine, die ihnen gemeinsam sind, "
        "zählen "
        "einmal."
    ),
    "E_n is the difference from the reference over the root of both squared U (k = 2); above 1 they disagree.": (
        "E_n ist der Unterschied zur Referenz durch die Wurzel beider quadrierter U (k = 2); über 1 widersprechen sie "
        "sich."
    ),
    "Drag to turn, wheel to zoom.": "Ziehen dreht, das Rad vergrößert.",
    "The machine in some of its poses.": "Die Maschine in einigen ihrer Posen.",
    "The machine where its path begins, and the path.": "Die Maschine am Anfang ihrer Bahn, und die Bahn.",
    "the machine in 3-D along its path": "die Maschine in 3-D entlang ihrer Bahn",
    "Magnitude of the correlation of two estimates; near 1 only their sum or difference is known well.": (
        "Betrag der Korrelation zweier Schätzungen; nahe 1 ist nur ihre Summe oder Differenz gut bekannt."
    ),
    "Lines: recorded, behind the evaluation's low-pass. Dotted: the identified model.": (
        "Linien: aufgezeichnet, hinter dem Tiefpass der Auswertung. Gepunktet: das identifizierte Modell."
    ),
    "Lines: recorded. Dotted: the identified model.": "Linien: aufgezeichnet. Gepunktet: das identifizierte Modell.",
    "What the model leaves of each channel. Noise without a pattern is good; waves and steps have a cause.": (
        "Was das Modell von jedem Kanal übrig lässt. Rauschen ohne Muster ist gut; Wellen und Stufen haben eine "
        "Ursache."
    ),
    "Of the forces as recorded.": "Von den Kräften, wie sie aufgezeichnet sind.",
    "Residuals in order over the quantiles of a normal distribution: a straight line where noise is normal, ends "
    "that bend away where there are gross errors or a part of the run that differs.": (
        "Geordnete Residuen über den Quantilen einer Normalverteilung: eine Gerade, wo Rauschen normal ist; gebogene "
        "Enden, wo es grobe Fehler gibt oder ein Teil des Laufs anders ist."
    ),
    # heads and cells of tables
    "parameter": "Parameter",
    "unit": "Einheit",
    "predicted std": "vorausgesagte Std.",
    "known": "bekannt",
    "with this run": "mit diesem Lauf",
    "parts of ±": "Anteile von ±",
    "delay": "Totzeit",
    "95 % from": "95 % von",
    "to": "bis",
    "std (28)": "Std. (28)",
    "std robust": "Std. robust",
    "given": "gegeben",
    "works": "brauchbar",
    "yes": "ja",
    "NO": "NEIN",
    "rank": "Rang",
    "condition": "Kondition",
    "residuals follow": "Residuen folgen",
    "as with": "wie bei",
    "share of their power": "Anteil ihrer Leistung",
    "chance of it by noise": "Wahrscheinlichkeit durch Rauschen",
    "channel": "Kanal",
    "white noise by its residuals": "weißes Rauschen nach seinen Residuen",
    "stated by the case": "nach der Maschine",
    "ratio": "Verhältnis",
    "residual as evaluated, rms": "Residuum wie ausgewertet (Effektivwert)",
    "of the forces as recorded": "der Kräfte wie aufgezeichnet",
    "strongest correlations": "stärkste Korrelationen",
    "component": "Komponente",
    "rms": "Effektivwert",
    "peak": "Spitze",
    "recorded": "aufgezeichnet",
    "payload [kg]": "Nutzlast [kg]",
    "without": "ohne",
    "with": "mit",
    "verdict": "Urteil",
    "of": "über",
    "limit": "Grenze",
    "PASS": "BESTANDEN",
    "FAIL": "NICHT BESTANDEN",
    "run": "Lauf",
    "share of chi-square": "Anteil am Chi-Quadrat",
    "without it: scatter / promised": "ohne ihn: Streuung / erwartet",
    "scatter of the runs": "Streuung der Läufe",
    "scatter / promised": "Streuung / erwartet",
    "nearest body that can exist": "nächster Körper, den es geben kann",
    "estimate": "Schätzung",
    "nearest": "nächster",
    "by deviations": "in Abweichungen",
    "beside the default": "neben dem Üblichen",
    "default": "üblich",
    "treated": "behandelt",
    "white noise": "weißes Rauschen",
    "samples": "Abtastungen",
    "more than ten times": "mehr als das Zehnfache",
    "nobody enforces it": "hält niemand ein",
    "enforced by the controller": "hält die Steuerung ein",
    "the controller steps, and does not limit it": "springt, von der Steuerung nicht begrenzt",
    # tiles
    "duration, from rest to rest": "Dauer, von Ruhe zu Ruhe",
    "condition in reference scaling": "Kondition in der Bezugsskalierung",
    "most that is used of any limit of position, speed or force": (
        "höchste Nutzung einer Grenze von Position, Geschwindigkeit oder Kraft"
    ),
    "mass": "Masse",
    "mass, with its standard deviation": "Masse, mit ihrer Standardabweichung",
    "largest force along an axis": "größte Kraft entlang einer Achse",
    "largest moment along an axis": "größtes Moment um eine Achse",
    # axes and legends
    "time": "Zeit",
    "standstill": "Stillstand",
    "frequency": "Frequenz",
    "position from home": "Position von der Grundstellung aus",
    "velocity": "Geschwindigkeit",
    "acceleration": "Beschleunigung",
    "force": "Kraft",
    "moment": "Moment",
    "residual": "Residuum",
    "recorded - model": "Aufzeichnung - Modell",
    "density": "Dichte",
    "deviation from the estimate": "Abweichung von der Schätzung",
    "normal quantile [standard deviations]": "Quantil der Normalverteilung [Standardabweichungen]",
    "normal, of their rms": "normal, mit ihrem Effektivwert",
    "path": "Bahn",
    "base": "Basis",
    "struts": "Streben",
    "forces": "Kräfte",
    "moments": "Momente",
    "drives": "Antriebe",
    "joints": "Drehgelenke",
    "positions": "Positionen",
    "angles": "Winkel",
    "not used": "nicht benutzt",
    "row": "Zeile",
    "platform": "Plattform",
    "sensors": "Sensoren",
    "tools": "Werkzeuge",
    "links": "Glieder",
    "kept out": "Sperrzonen",
    "joints and sensor": "Gelenke und Sensor",
    "convex bodies": "konvexe Körper",
    "origin of {P}": "Ursprung von {P}",
    "axes of the sensor": "Achsen des Sensors",
    "axes of the flange": "Achsen des Flanschs",
    "axes of the tool": "Achsen des Werkzeugs",
    "Play": "Abspielen",
    "use of each limit": "Nutzung jeder Grenze",
    "warnings": "Warnungen",
    "equal": "gleich",
    "certified": "bewiesen",
    "an estimate": "geschätzt",
    "% of det J^-1 at home": "% von det J^-1 in der Grundstellung",
    "{P}, the platform": "{P}, die Plattform",
    "the robot's flange": "dem Flansch des Roboters",
    "the robot's tool (TCP)": "dem Werkzeug des Roboters (TCP)",
    "converged": "am Ziel",
    "every candidate": "jeder Kandidat",
    "poses of one's own": "eigene Posen",
    "as many as asked for": "so viele wie verlangt",
}
FIXED: Mapping[str, str] = (
    _WORDS
    | {
        f"{english} of each {of} over time; dashed: the limits of the axis in its colour.": (
            f"{german}, jede {kind}, über der Zeit; gestrichelt: die Grenzen der Achse in ihrer Farbe."
        )
        for english, german in _MOTION.items()
        for of, kind in _AXES.items()
    }
    | {f"{axis} of {{P}} at the poses": f"{axis} von {{P}} in den Posen" for axis in "xyz"}
    | {
        f"{english} {axis}": f"{german} {axis}"
        for english, german in (("force", "Kraft"), ("moment", "Moment"))
        for axis in "xyz"
    }
    | {f"centre of gravity, {axis}": f"Schwerpunkt, {axis}" for axis in "xyz"}
)
"""English -> German."""

WORDS_OF_MACHINE = {
    "play": "Abspielen", "pause": "Pause", "pose": "Pose", "of": "von", "path": "Bahn", "poses": "Posen",
    "decimal": ",",
}  # fmt: skip
"""Words of the buttons beside a machine in 3-D, and of its legend."""

TERMS = {
    "Std. (28)": "Standardabweichung, wenn die Residuen weißes Rauschen sind, Gleichung (28) von Friedrich & "
    "Ihlenfeldt "
    "2021",
    "Std. robust": "Standardabweichung, die zulässt, dass sich Residuen von einer Abtastung oder Pose zur nächsten "
    "gleichen",
    "s0": "Standardabweichung der aufgezeichneten Kräfte vom Modell, Gleichung (27)",
    "weißes Rauschen": "Rauschen einer Kraft ohne Gedächtnis, wie es die Residuen hinter dem Filter der Auswertung "
    "zeigen",
    "D-Effizienz": "Anteil der Information, die keine Bewegung in den Grenzen übertreffen kann, von 0 bis 1",
    "Bezugsskalierung": "Parameter nach ihrer Wirkung auf die Sensoren im Bewegungsraum skaliert, damit sich "
    "Bewegungen "
    "vergleichen lassen",
    "Regressors": "der Matrix, die aus Parametern Kräfte macht",
    "Kondition": "größter durch kleinsten Singulärwert: 1 ist am besten, groß, wo sich Parameter schwer trennen lassen",
    "Effektivwert": "Wurzel des Mittels der Quadrate",
}
"""Terms that a page explains where they stand."""


REPORTS = {
    "sound_run": "nichts spricht gegen diesen Lauf",
    "sound_runs": "nichts spricht gegen beide Läufe",
    "exceeded_and": "ÜBERSCHRITTEN, {words}",
    "allowed_least": "mindestens {limit}",
    "allowed_most": "höchstens {limit}",
    "allowed_between": "von {low} bis {high}",
    "allowed_limit": "Grenze {limit}",
    "room_left": "{size} übrig",
    "room_beyond": "{size} darüber hinaus",
    "limits_kept": "keine Grenze der Maschine ist überschritten: bewiesen bei 10 kHz",
    "limits_exceeded": "ÜBERSCHRITTEN, von ihrer Steuerung nicht begrenzt: {limits}",
    "without_as_planned": "{words}, ohne {left_out}, wie geplant",
    "page_of_plan": "Plan: {machine}",
    "page_of_result": "Identifikation: {machine}",
    "efficiency_measured": "D-Effizienz {measure}",
    "of_design": "gegenüber der besten Wahl aus {count} Kandidaten (untere Schranke)",
    "of_box_bound": "gegenüber der Schranke des Bewegungsraums ({label})",
    "stopped_early": "mit Ctrl-C angehalten: das Beste, was bis dahin gefunden war",
    "assumed_standing": "vorausgesagt für {noise} N weißes Rauschen einer gemittelten Kraft",
    "assumed_moving": "vorausgesagt für {noise} N weißes Rauschen einer Kraft, {rate} Hz, {mounted}, Gewichte "
    "{weights}",
    "tolerances_missing": "{assumed}; keine Toleranzen von {kinds} sind enthalten: siehe [tolerances]",
    "one_payload": "1 Nutzlast",
    "payloads": "{count} Nutzlasten",
    "to_payloads": "{least} bis {most}",
    "more_seconds": "mehr Sekunden senken",
    "longer_averages": "längere Mittelung senkt",
    "from_to_at_most": "von {now} auf höchstens {least} {unit}",
    "by_nothing": "um nichts, es bleibt bei {now} {unit}",
    "lasting": "{longer} {name} {gain}: Toleranzen von {kind} sind {percent} % seiner Varianz",
    "and_likewise": "{whole}; ebenso {others}",
    "falls_to": "{name} auf {percent} %",
    "known_by": "bekannt durch {named}: Mit diesem Lauf sinken die Abweichungen, am meisten {falls} dessen, was sie "
    "sind",
    "still_loose": "noch lose, denn Rauschen ist das meiste ihrer Varianz: {loose}",
    "nothing_loose": "nichts ist danach noch lose: Toleranzen sind das meiste jeder Varianz",
    "so_many_poses": "{count} Posen",
    "headline": "Plan für {machine}: {subject}, {seconds} s, Kriterium {criterion}, Modell {model}",
    "headline_without": "{line}, ohne {left_out}",
    "columns_alike": "Betrag der Pearson-Korrelation der Spalten des Regressors, Modell {model}: nahe 1 machen zwei "
    "Parameter fast dieselben Kräfte.",
    "r_of_regressor": "Betrag von R der QR-Zerlegung des skalierten Regressors. Ein Diagonalelement von numerisch null "
    "({zero}): Die Parameter davor machen dieselben Kräfte. Ein großer Wert über der Diagonale: Der Parameter der "
    "Spalte "
    "hängt von dem der Zeile ab.",
    "this_model": "{model} (dieses)",
    "rank_of": "{rank} von {count}",
    "of_models": "Modelle {numbers}: {sentence}.",
    "of_model": "Modell {number}: {sentence}.",
    "changes_nothing": "{name} ändert hier keine Kraft",
    "change_nothing": "{names} ändern hier keine Kraft",
    "not_apart": "{names} lassen sich nicht unterscheiden: Eine Kombination von ihnen ändert keine Kraft",
    "not_apart_by": "{names} lassen sich nicht unterscheiden: {count} Kombinationen von ihnen ändern keine Kraft",
    "nearly_alike": "fast gleich, und darum nur zusammen genau bekannt: {pairs}",
    "pairs_more": "{pairs} und {count} weitere Paare",
    "pair_correlated": "{one} und {other} ({value})",
    "so_many_of": "{count} von {block}",
    "force_over_time": "Äußere Kraft auf die Last, Koordinatensystem: {frame}. Gepunktet: U (k = 2) darunter und "
    "darüber.",
    "moment_over_time": "Äußeres Moment um den Ursprung des Koordinatensystems: {frame}. Gepunktet: U (k = 2) "
    "darunter und "
    "darüber.",
    "rms_of_deviations": "± und U (k = 2) sind Effektivwerte über die Aufzeichnung",
    "none_counted": "sie enthalten keine Toleranzen von {kinds}: siehe [tolerances] der Maschine",
    "so_many_samples": "{count} Abtastungen",
    "so_many_standstills": "{count} Stillstände",
    "so_many_averaged": "{count} gemittelten Stillständen",
    "what_acted": "Was über {recording} ({size}) von außen auf die Last wirkte: gemessene Kräfte ohne die, welche die "
    "Parameter von {parameters} erklären.",
    "beside_reference": "{verdict}: E_n neben der Referenz",
    "beside_reference_is": "Neben der Referenz: {verdict}",
    "counted_in_frame": "Vom Ursprung und entlang der Achsen des Koordinatensystems: {frame}.",
    "carries_more": "Was {loaded} mehr trägt als {empty}: Differenzen beider Schätzungen, mit den Abweichungen beider.",
    "nothing_leaps": "nichts springt oder driftet über seine Abweichung hinaus",
    "leapt": "{parameter} sprang um {size} {unit} von {before} bis {after}, {times} Abweichungen",
    "drifts_daily": "{parameter} driftet um {size} {unit} am Tag, {times} Abweichungen",
    "single_result": "1 Ergebnis",
    "so_many_results": "{count} Ergebnisse",
    "history_of": "{results} von {machine} von {first} bis {last}. Ein Sprung ist eine Änderung zwischen zwei "
    "Ergebnissen, "
    "die aufeinander folgen, mit derselben Nutzlast, die über ihr eigenes Rauschen und die Toleranzen hinausgeht.",
    "over_time": "{parameter} über der Zeit, mit seiner Abweichung",
    "not_judged_are": "nicht beurteilt: {reasons}",
    "verdict_is": "Urteil: {verdict}",
    "evaluated_as": "Ausgewertet: {words}. Unterschiede sind Anteile der üblichen Abweichungen.",
    "identified_from": "Modell {model}, identifiziert aus {samples} von {source}.",
    "mass_is": "Masse {value} kg",
    "more_below": "{count} weitere darunter",
    "condition_and_rank": "Kondition des skalierten Regressors, Rang {rank}",
    "s0_weighted": "s0 (27), 1, wo die Gewichte stimmen (weißes Rauschen {noise}, aufgezeichnete Kräfte ohne das "
    "Modell "
    "{rest} N Effektivwert)",
    "noise_standing": "weißes Rauschen {noise} N",
    "noise_moving": "weißes Rauschen nach dem Durchlassband des Filters {noise} N",
    "s0_newtons": "s0 (27), aufgezeichnete Kräfte ohne das Modell ({noise})",
    "larger_of_both": "± ist die größere von Std. (28), für die das Rauschen weiß ist, und Std. robust, für die nicht",
    "about_axes_of": "Um den Ursprung und entlang der Achsen von {frame}:",
    "forces_lag": "Die Kräfte folgen der Bewegung um {lag} ± {std} ms: mit den Parametern geschätzt.",
    "spectrum_filtered": "Von den Kräften, wie sie aufgezeichnet sind. Gestrichelt: der Tiefpass der Auswertung bei "
    "{cutoff} "
    "Hz; was darüber liegt, wie die Welligkeit einer Steuerung, sieht die Schätzung nicht.",
    "lines_and_dashed": "Linien: nach den Antrieben, hinter dem Filter der Auswertung; gestrichelt: geplant",
    "drives_alone_shown": "nach den Antrieben, hinter dem Filter der Auswertung",
    "of_plan_alone": "geplant",
    "of_translation": "Beschleunigungen der Translation des Koordinatensystems der Last",
    "of_rotation": "Beschleunigungen der Rotation des Koordinatensystems der Last",
    "accelerations_of": "{words} in {base} von {name}: {shown}.",
    "accelerations": "{words} in {base}: {shown}.",
    "no_time_shared": "Plan und Lauf haben keine Zeit gemeinsam",
    "rms_of": "{size} von {whole} {unit} Effektivwert",
    "measured_less_planned": "gemessene ohne geplante Beschleunigungen: Translation {translation}, Rotation {rotation}",
    "density_of": "Normalverteilung von {names} um die Schätzung, nach der angegebenen Standardabweichung: je "
    "schmaler und "
    "höher, desto besser bekannt.",
    "refined": "verfeinert ({status})",
    "nothing_better": "{status}; nichts Besseres gefunden",
}
"""Sentences by their codes."""
