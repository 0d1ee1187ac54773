"""Words of the stage Result: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
    "result_lead": (
        "What the run says, and how far to trust it.",
        "Was der Lauf sagt, und wie weit man ihm trauen kann.",
    ),
    "results": ("Results", "Ergebnisse"),
    "verdict_good": ("Nothing speaks against this run.", "Nichts spricht gegen diesen Lauf."),
    "unseen": ("What this run cannot show", "Was dieser Lauf nicht zeigen kann"),
    "unseen_worst": (
        "Errors of the machine or the recorder that half of all runs like this one would not show, of this size; the "
        "worst for a value:",
        "Fehler von Maschine oder Rekorder, die in dieser Größe die Hälfte aller solchen Läufe nicht zeigte; am "
        "schlimmsten für einen Wert bei",
    ),
    "unseen_note": (
        "U does not count them, for no data of this run tell whether they are there: it counts what [tolerances] of "
        "the case allow for, such as clock_ppm for time stamps. State there how good the parts of your machine are.",
        "U enthält sie nicht, denn keine Daten dieses Laufs sagen, ob es sie gibt: es enthält, was [tolerances] der "
        "Maschine zulassen, etwa clock_ppm für Zeitstempel. Dort angeben, wie genau die Teile Ihrer Maschine sind.",
    ),
    "unseen_state": ("State tolerances", "Toleranzen angeben"),
    "unseen_largest": ("The largest {shown} of {count}", "Die größten {shown} von {count}"),
    "unseen_cause": ("an error that may be there unseen", "Fehler, der unbemerkt da sein kann"),
    "unseen_bias": ("moves the value by", "verschiebt den Wert um"),
    "identify_again": ("Identify {what} again", "{what} neu auswerten"),
    "again_note": (
        "With the case as it is now; exports and certificates are then of a result that is up to date.",
        "Mit der Maschine, wie sie jetzt ist; Exporte und Scheine sind dann von einem gültigen Ergebnis.",
    ),
    "again_gone": (
        "Exports and certificates of a result that is out of date are refused: bring its recording on the stage Data "
        "again, and identify.",
        "Exporte und Scheine eines überholten Ergebnisses werden verweigert: seine Aufzeichnung im Schritt Daten noch "
        "einmal bringen und auswerten.",
    ),
    "use_failed": (
        "What is exported or certified here is of this result.",
        "Was hier exportiert oder bescheinigt wird, ist von diesem Ergebnis.",
    ),
    "to_result": ("To the verdict", "Zum Urteil"),
    "verdict_fails": ("The result fails acceptance", "Das Ergebnis besteht die Abnahme nicht"),
    "verdict_doubt": ("Look at this before you use the values", "Vor der Nutzung der Werte ansehen"),
    "verdict_counted": ("Usable: the deviations allow for this", "Nutzbar: Die Abweichungen berücksichtigen dies"),
    "verdict_simulated": ("A rehearsal: sensors were simulated.", "Eine Probe: Die Sensoren waren simuliert."),
    "more_findings": ("Further findings", "Weitere Befunde"),
    "to_menus": ("Change how the recording is read", "Ändern, wie die Aufzeichnung gelesen wird"),
    "value": ("value", "Wert"),
    "deviation": ("±", "±"),
    "with_rods": (
        "Mass, centre of gravity and inertia include the six rods ({mass} kg), which sensors at the drives carry.",
        "Masse, Schwerpunkt und Trägheit enthalten die sechs Stäbe ({mass} kg), die die Sensoren an den Antrieben "
        "mittragen.",
    ),
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
    "accept": ("Acceptance", "Abnahme"),
    "accept_stated": ("Limits by [accept] of the case.", "Grenzwerte nach [accept] der Maschine."),
    "accept_default": (
        "The case states no [accept]: the usual limits are used.",
        "Die Maschine nennt kein [accept]: Es gelten die üblichen Grenzwerte.",
    ),
    "at_least": ("at least {limit}", "mindestens {limit}"),
    "at_most": ("at most {limit}", "höchstens {limit}"),
    "pass": ("PASS", "BESTANDEN"),
    "fail": ("FAIL", "NICHT BESTANDEN"),
    "judged": ("verdict", "Urteil"),
    "check_of": ("what is judged", "was beurteilt wird"),
    "unjudged": ("Not judged", "Nicht beurteilt"),
    "accept_form": ("State acceptance limits", "Grenzwerte der Abnahme festlegen"),
    "accept_save": ("Write into the case", "In die Maschine schreiben"),
    "accept_noise_times": (
        "Largest noise of a channel, as a multiple of the stated one",
        "Größtes Rauschen eines Kanals, als Vielfaches des genannten",
    ),
    "accept_mass_percent": (
        "Largest difference of the mass from nominal, %",
        "Größte Abweichung der Masse vom Nennwert, %",
    ),
    "accept_path_percent": (
        "Smallest share of the planned path in the run, %",
        "Kleinster Anteil der geplanten Bahn im Lauf, %",
    ),
    "accept_duration_percent": ("Largest difference of the duration, %", "Größte Abweichung der Dauer, %"),
    "accept_path_error_mm": ("Largest distance from the planned path, mm", "Größter Abstand von der Bahn, mm"),
    "accept_deviations_mass_kg": ("Largest ± of the mass, kg", "Größtes ± der Masse, kg"),
    "accept_deviations_centre_of_gravity_mm": (
        "Largest ± of the centre of gravity, mm",
        "Größtes ± des Schwerpunkts, mm",
    ),
    "accept_deviations_inertia_kg_m2": ("Largest ± of the inertia, kg m^2", "Größtes ± der Trägheit, kg m^2"),
    "accept_deviations_offset_N": ("Largest ± of an offset of force, N", "Größtes ± eines Kraft-Nullpunkts, N"),
    "accept_deviations_offset_Nm": (
        "Largest ± of an offset of moment, N m",
        "Größtes ± eines Momenten-Nullpunkts, N m",
    ),
    "accept_reference_mass_kg": ("Mass of a weighed reference, kg", "Masse einer gewogenen Referenz, kg"),
    "accept_reference_mass_U_kg": ("U (k=2) of that mass, kg", "U (k=2) dieser Masse, kg"),
    "values_found": ("Parameters", "Parameter"),
    "counted": ("U counts: {what}.", "U enthält: {what}."),
    "counted_noise": (
        "U counts noise, with its memory, and what the residuals show.",
        "U enthält das Rauschen mit seinem Gedächtnis und was die Residuen zeigen.",
    ),
    "budget": ("Where ± comes from", "Woher ± kommt"),
    "share": ("shares of the variance", "Anteile der Varianz"),
    "largest": ("the largest", "der größte"),
    "residuals": ("Residuals of each channel", "Residuen jedes Kanals"),
    "force_channel": ("channel", "Kanal"),
    "residual_rms": ("rms residual", "Residuum (Effektivwert)"),
    "noise_measured": ("noise by the residuals", "Rauschen nach den Residuen"),
    "noise_stated": ("noise that the case states", "Rauschen nach der Maschine"),
    "compare": ("Another result beside this one", "Ein anderes Ergebnis daneben"),
    "compare_do": ("Show them side by side", "Nebeneinander zeigen"),
    "beside": ("Beside {what}", "Neben {what}"),
    "difference": ("difference", "Unterschied"),
    "en_note": (
        "E_n is the difference over its U (k=2); above 1 they disagree. Tolerances by which both results are off alike "
        "cancel in it.",
        "E_n ist der Unterschied durch sein U (k=2); über 1 widersprechen sie sich. Toleranzen, um die beide "
        "Ergebnisse gleich falsch sind, heben sich darin auf.",
    ),
    "pooled": ("The runs, and which of them differs", "Die Läufe, und welcher abweicht"),
    "pooled_agree": (
        "The runs agree: chi-square {chi2} for {freedom} degrees of freedom, p = {p}.",
        "Die Läufe stimmen überein: Chi-Quadrat {chi2} bei {freedom} Freiheitsgraden, p = {p}.",
    ),
    "pooled_apart": (
        "The runs differ by more than their deviations say: chi-square {chi2} for {freedom} degrees of freedom, "
        "p = {p}. Look at the run with the largest share.",
        "Die Läufe weichen stärker ab, als ihre Abweichungen sagen: Chi-Quadrat {chi2} bei {freedom} Freiheitsgraden, "
        "p = {p}. Den Lauf mit dem größten Anteil ansehen.",
    ),
    "chi2_share": ("share of chi-square", "Anteil am Chi-Quadrat"),
    "without_it": ("the others without it: scatter / promised", "die anderen ohne ihn: Streuung / erwartet"),
    "scatter": ("How far each parameter scatters", "Wie weit jeder Parameter streut"),
    "scatter_promised": ("scatter / promised", "Streuung / erwartet"),
    "payload_to": ("Write it as", "Schreiben als"),
    "payload_table": ("a table and a page", "Tabelle und Seite"),
    "payload_frame": (
        "Frame, of the table, links and robots' tables; empty: the sensor's, or as usual for the target",
        "Koordinatensystem, für Tabelle und Glieder; leer: das des Sensors, oder wie für das Ziel üblich",
    ),
    "payload_in": ("In the frame: {what}", "Im Koordinatensystem: {what}"),
    "payload_page": ("The page of the payload", "Die Seite der Nutzlast"),
    "reference_of": ("What {what} should be, {unit} (if known)", "Sollwert von {what}, {unit} (falls bekannt)"),
}
