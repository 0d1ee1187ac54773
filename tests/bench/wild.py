"""Files of the field that once failed, taken the way a user takes them: by the command line, with its own remedies.

Each recording is identified with the case beside it. What is refused is mended as the command says: by the keys that
it offers, else by `look --write`. The row says by which way the truth was reached, or what was said instead. Programs,
bags and cases are read by the command that their README names; what is said must hold a word of the right answer.

Usage: python tests/bench/wild.py [FOLDER ..] [--wild ../shared/wild]
"""

import argparse
import json
import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from tests.hexcite.command_line import Answer, call

ROOT = Path(__file__).parents[2]
FAR = 4.0  # reported deviations: an estimate further from the truth is a wrong number
STEPS = 4  # remedies that are followed one after the other
MILL = {"m": 21.40, "xC": 4.0e-3, "yC": -11.0e-3, "zC": 95.0e-3}
ARM = {"m": 2.610, "xC": 4.0e-3, "yC": -7.0e-3, "zC": 86.0e-3}
TABLE = {"m": 17.400, "xC": 3.0e-3, "yC": -5.0e-3, "zC": 84.0e-3}
HX64 = {"m": 41.37, "xC": 7.4e-3, "yC": -4.2e-3, "zC": 203.5e-3}
PLANT = {"m": 31.830}


class Recording(NamedTuple):
    """Files of one run, the case that evaluates them (of its folder, or built in), and its truth in SI."""

    files: tuple[str, ...]
    truth: dict[str, float]
    case: str = "case.toml"
    said: str = ""  # pattern of the refusal that is right where nothing but another recording helps
    known: tuple[str, ...] = ()  # what the user alone knows, as `case set` takes it, where the command asks for it


class Command(NamedTuple):
    """A command in a folder, the exit codes that are right, and a pattern of what has to be said."""

    arguments: tuple[str, ...]
    codes: tuple[int, ...]
    said: str


def run(
    *files: str, truth: dict[str, float], case: str = "case.toml", said: str = "", known: tuple[str, ...] = ()
) -> Recording:
    """A recording of one or more files."""
    return Recording(files, truth, case, said, known)


def command(text: str, said: str, *codes: int) -> Command:
    """A command line, by its words."""
    return Command(tuple(text.split()), codes or (0,), said)


def _of_two_channels() -> list[str]:
    """Tables of the two files of halsampler, which hold names that `look` cannot know."""
    drives, forces = [f"l{k}_mm" for k in range(1, 7)], [f"f{k}_N" for k in range(1, 7)]
    tables = [("struts_c*.txt", ["trigger", *drives]), ("forces_c*.txt", forces)]
    return [
        "recording.files=["
        + ", ".join(
            f'{{ match = "{name}", format = "halsampler", column_names = {names}, clock = {{ period_ms = 2.0 }} }}'
            for name, names in tables
        )
        + "]"
    ]


ROBOT = "ur10_wrist"
FOLDERS: dict[str, list[Recording | Command]] = {
    "angles_u_v_w": [run("run.csv", truth=MILL)],
    "axis_letters_in_look": [run("run.csv", truth=TABLE)],
    "bags": [
        *(run(bag, truth=ARM, case=ROBOT) for bag in ("ok", "without_metadata", "without_metadata/ok.mcap", "run.bag")),
        command(f"identify stamps_of_no_use --case {ROBOT}", "no time|receipt", 1),
        command(f"identify base_frame --case {ROBOT}", "in the frame base", 1),
        command(f"look ok --case {ROBOT} -o l.svg", "joint_states"),
    ],
    "binary_for_identify": [
        command("identify run.mat --case case.toml", "MATLAB", 1),
        command("identify run.tdms --case case.toml", "TDMS|LabVIEW", 1),
    ],
    "catman_time": [command("look csv.txt --case case.toml -o l.svg", "t_s +s\\b", 0, 1)],
    "date_stamps": [run("iso.csv", truth=MILL), run("timeofday.csv", truth=MILL)],
    "export_urscript_flange": [
        command("identify run.txt --case case.toml -o result", "2[.]61"),
        command("export result --to urscript -o load.script", "machine.chain.flange", 1),
    ],
    "good": [run("run.csv", truth=ARM, case=ROBOT)],
    "halsampler_look": [
        run("tagged.txt", truth=MILL),
        run(
            "struts_c0.txt", "forces_c1.txt", truth=MILL,
            known=("recording.column_names", "recording.format", *_of_two_channels()),
        ),
    ],
    "home_on_a_limit": [command("case check case.toml", "home|case checked|limits")],
    "host_jitter": [run("run.csv", truth=MILL)],
    "host_stamps_csv": [run("run.csv", truth=ARM, case=ROBOT)],
    "hx64_mistakes": [
        run("empty.csv.gz", truth=HX64),
        *(
            run("empty.csv.gz", truth=HX64, case=f"{case}.toml")
            for case in (
                "m2a_half_other_way", "m2c_full_angle", "m4b_platform_above", "m4c_home_neg", "m5a_rings_swapped",
                "m5c_diameter_plat", "m6b_upper_only",
            )
        ),
        command("case check m1a_deg_in_rad.toml", "acceleration", 0, 1),
        command("case check n4_acc_mm.toml", "acceleration", 0, 1),
        command("case check n5_strut_vel_mm.toml", "m/s", 0, 1),
        command("case check n8_cog_m.toml", "centre|mm", 0, 1),
        command("case check case.toml", ""),
    ],
    "internal_error_headless": [
        command("look headless.csv --case case.toml -o l.svg", "column_names", 0, 1),
        run("headless.csv", truth=MILL, said="name them so or map them"),
    ],
    "joints_in_rad": [run("run.csv", truth=ARM, case=ROBOT)],
    "labview_lvm": [
        command(f"look {file}.lvm --case case.toml -o l.svg", "X_Value +t_s", 0, 1) for file in ("one", "comment")
    ],
    "line_numbers": [
        command("check plain.ngc --case case.toml", "proven", 0, 1),
        command("check numbered.ngc --case case.toml", "proven", 0, 1),
    ],
    "look_many_columns": [command(f"look log.csv --case {ROBOT} -o l.svg", "", 0, 1)],
    "look_names": [
        run("brackets.csv", truth=ARM, case=ROBOT), run("plotjuggler.csv", truth=ARM, case=ROBOT),
        run("aligned.txt", truth=ARM, case=ROBOT),
    ],
    "look_tcp_force": [command(f"look run.txt --case {ROBOT} -o l.svg", "ft_raw_wrench", 0, 1)],
    "one_message_for_all": [
        run(f"{name}.csv", truth={"m": ARM["m"]}, case=ROBOT, said="in the axes of the base, not of the sensor")
        for name in ("base_frame", "joints_alphabetic", "turn30", "turn90", "wall")
    ],
    "pose_kuka_abc": [run("standstills.csv", truth=ARM)],
    "pose_rotation_vector": [run("standstills.csv", truth=ARM)],
    "poses_duplicates": [command("check poses.nc --case case.toml --dialect twincat", "", 1)],
    "raw_counts": [
        run(
            "run.csv", truth=MILL,
            known=(
                "recording.scale={ f1_N = 0.1526, f2_N = 0.1531, f3_N = 0.1519, f4_N = 0.1528, f5_N = 0.1524, "
                "f6_N = 0.1530 }",
            ),
        )
    ],
    "robot_csv": [
        command(
            "look hand_joints.csv.gz hand_wrench.csv.gz --case gen3_case --write gen3_case -o l.svg", "position"
        ),
        command("identify hand_joints.csv.gz hand_wrench.csv.gz --case gen3_case --standstills -o r", "mass"),
        command("look effort_position.csv.gz --case gen3_case -o l.svg", "position"),
        command(f"look pattern.csv --case {ROBOT} -o l.svg", "85 samples are missing; bridged"),
    ],
    "ros2_clearance": [command("post plan12 --case table_case -o k.yaml", "proven|clearance", 0, 1)],
    "ros2_short_piece": [command("post plan --dialect ros2 -o run.yaml", "", 0, 1)],
    "scope_equal_names": [run("all.csv.gz", truth=HX64)],
    "scope_filetime_look": [
        command("look filetime.csv --case case.toml -o l.svg", 'unit = "filetime".*rate_Hz = 500', 0, 1),
        command("look full_timestamp.csv --case case.toml -o l.svg", "500 a second", 0, 1),
    ],
    "scope_two_sample_times": [run("run.csv", truth=MILL)],
    "seconds_that_are_ms": [run("run.csv", truth=MILL)],
    "sinumerik_trace_sparse": [run(name, truth=MILL) for name in ("run.csv", "held.csv", "run.xml")],
    "small_angles_called_radians": [command("case check case.toml", "^(?!.*radian)")],
    "trace_started_by_the_program": [command("check trace.mpf --case hexapod", "", 0, 1)],
    "trigger_bits": [run("run.csv", truth=ARM, case=ROBOT)],
    "trunnion_turns_the_other_way": [run("run.csv", truth=TABLE), run("as_the_case.csv", truth=TABLE)],
    "two_recorders": [
        run("struts.txt", "forces.csv", truth=MILL),
        run("struts_plain.csv", "forces_plain.csv", truth=MILL, case="plain"),
    ],
    "unknown_unit_taken_for_N": [run("lbf.csv", truth=MILL)],
    "ur_raw_offsets": [run("run.csv", truth=ARM, case=ROBOT)],
    "urdf_optional_values": [
        command(f"case new c_{name} --urdf {name}.urdf --flange ft_sensor -o c_{name}", "", 0, 1)
        for name in ("unphysical", "pointmass", "vel0", "inf", "degrees")
    ],
    "utf16": [run("run.txt", truth=MILL)],
    "words_for_values": [run("true_false.csv", truth=MILL)],
    "attack": [
        *(
            run(f"silent_{name}/recording.csv.gz", truth=truth, case=case)
            for name, truth, case in (
                ("arm_gain_fx_5pc", ARM, ROBOT), ("arm_hose_20N_m", ARM, ROBOT),
                ("arm_joint_step_0.05deg", ARM, ROBOT), ("clock_1000ppm", PLANT, "hexapod"),
                ("encoder_step_100um", PLANT, "hexapod"), ("resonance_12Hz", PLANT, "hexapod"),
                ("struts_lowpassed_5ms", PLANT, "hexapod"),
            )
        ),
        *(
            command(f"check {file} --case hexapod", "", 1)
            for file in (
                "arc_with_P/arc_tiny_9e-8.ngc", "arc_with_P/g4_arc.ngc", "arc_with_P/m64_arc.ngc",
                "linuxcnc_python_comment/evil.ngc", "linuxcnc_python_comment/logopen.ngc",
            )
        ),
        *(
            command(f"check {file} --case hexapod", "", 0, 1)
            for file in (
                "linuxcnc_collinear/col_collinear_100.ngc", "linuxcnc_modal_state/arc_without_G91.1.ngc",
                "linuxcnc_modal_state/one_block_start.ngc",
            )
        ),
        *(command(f"check ros2_edited/{name}.yaml --case {ROBOT}", "", 1) for name in ("octal", "shifted")),
        command(f"check ros2_edited/base.yaml --case {ROBOT}", "", 0, 1),
        *(command(f"identify damaged_bags/{bag} --case {ROBOT}", "bag|cannot", 1) for bag in ("mcap", "sqlite")),
        *(
            command(f"look look_stopiteration/{file}.csv --case hexapod -o l.svg", "", 0, 1)
            for file in ("decimal_comma", "index_error")
        ),
        *(command(f"case check toml_internal_errors/{f}.toml", "toml", 1) for f in ("huge_int", "deep_array")),
        command("case new arm --urdf urdf_injection/newline_base.urdf --flange tool0 -o x", "", 0, 1),
    ],
}  # fmt: skip


class Row(NamedTuple):
    """What became of a file: right, flagged, refused or WRONG, by which way, and what was said."""

    name: str
    word: str
    way: str
    said: str


def taken(of: Recording, folder: Path) -> Row:
    """Identifies a run, and follows what the command offers until it is evaluated."""
    case = folder / "own"
    begin(of.case, folder, case)
    files, ways = [folder / file for file in of.files], ["as it is"]
    for _ in range(STEPS):
        answer = call("identify", *files, "--case", case, "-o", folder / "result", "--overwrite", "--json")
        if "internal error" in answer.err or "Traceback" in answer.err:
            return Row(" ".join(of.files), "INTERNAL", ", ".join(ways), answer.err)
        if not answer.out:
            return refusal(of, ways, answer.err)
        said = json.loads(answer.out)
        if "physical" in said or "parameters" in said:
            word, text = judged(said, of.truth)
            keys = offered(said)
            if word == "flagged" and keys and ways[-1] != f"case set {' '.join(keys)}":
                ways.append(f"case set {' '.join(keys)}")
                call("case", "set", case, *keys)
                continue
            return Row(" ".join(of.files), word, ", ".join(ways), text)
        keys = offered(said)
        if keys and f"case set {' '.join(keys)}" not in ways:
            ways.append(f"case set {' '.join(keys)}")
            written = call("case", "set", case, *keys)
        elif "look --write" not in ways:
            ways.append("look --write")
            written = call("look", *files, "--case", case, "--write", case, "-o", folder / "l.svg", "--overwrite")
        elif of.known and "what the user knows" not in ways:
            ways.append("what the user knows")
            written = call("case", "set", case, *of.known)
        else:
            return refusal(of, ways, answer.err)
        if written.code and not of.known:
            return refusal(of, ways, answer.err + written.err)
    return refusal(of, ways, answer.err)


def refusal(of: Recording, ways: list[str], said: str) -> Row:
    """A run that is not evaluated, as it should or not."""
    word = "as it should" if of.said and re.search(of.said, said) else "REFUSED"
    return Row(" ".join(of.files), word, ", ".join(ways), " / ".join(said.splitlines()))


def begin(name: str, folder: Path, case: Path) -> None:
    """A case of one's own: that of a file, or one that is built in."""
    shutil.rmtree(case, ignore_errors=True)
    if (folder / name).is_dir():
        shutil.copytree(folder / name, case)
    elif name.endswith(".toml"):
        case.mkdir()
        shutil.copy(folder / name, case / "case.toml")
    else:
        shutil.copytree(ROOT / "cases" / name, case)


def offered(said: dict[str, Any]) -> list[str]:
    """Keys of the first remedy that has some, as `case set` takes them."""
    remedies = [*said.get("error", {}).get("remedies", ()), *said.get("remedies", ())]
    for finding in said.get("findings", ()):
        if finding.get("severity") == "warning":
            remedies += finding.get("remedies", ())
    for remedy in remedies:
        if remedy.get("keys"):
            return [written(place, value) for place, value in remedy["keys"]]
    return []


def written(place: list[str | int], value: object) -> str:
    """A key with its value, as it is typed."""
    name = ""
    for part in place:
        name += f"[{part + 1}]" if isinstance(part, int) else f".{part}" if name else part
    return name if value is None else f"{name}={toml(value)}"


def toml(value: object) -> str:
    """A value as TOML has it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(each)}" for key, each in value.items()) + " }"
    return json.dumps(value)


def judged(said: dict[str, Any], truth: dict[str, float]) -> tuple[str, str]:
    """Right, flagged or WRONG by the truth in reported deviations, and estimates with the first warning."""
    physical = said.get("physical") or said["parameters"]
    errors = {name: (entry(physical[name])[0] - true) / entry(physical[name])[1] for name, true in truth.items()}
    mass, deviation = entry(physical["m"])
    text = f"m {mass:.4f} +- {deviation:.4f} kg, worst {max(errors.values(), key=abs):+.1f} deviations"
    warned = said.get("warnings") or []
    word = "flagged" if warned else "WRONG" if max(map(abs, errors.values())) > FAR else "right"
    return word, f"{text}; {warned[0] if warned else ''}"


def entry(of: dict[str, Any]) -> tuple[float, float]:
    """Value and reported deviation."""
    return of["value"], of.get("reported") or max(of["std"], of.get("std_robust") or 0.0)


def answered(of: Command, folder: Path) -> Row:
    """Runs a command on files of the folder."""
    words = [str(folder / word) if (folder / word).exists() else word for word in of.arguments]
    words = [str(folder / words[k]) if k and words[k - 1] == "-o" else words[k] for k in range(len(words))]
    answer: Answer = call(*words, *(["--overwrite"] if words[0] == "look" else []))
    text = " / ".join((answer.err + answer.out).strip().splitlines())
    internal = "internal error" in answer.err or "Traceback" in answer.err
    fits = answer.code in of.codes and re.search(of.said, text) is not None
    word = "INTERNAL" if internal else "as it should" if fits else "NOT AS IT SHOULD"
    return Row(" ".join(of.arguments), word, f"exit {answer.code}", text)


def rows(wild: Path, names: list[str]) -> Iterator[tuple[str, Row]]:
    """Every folder's rows."""
    for name in names or FOLDERS:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(shutil.copytree(wild / name, Path(place) / name))
            for of in FOLDERS[name]:
                yield name, taken(of, folder) if isinstance(of, Recording) else answered(of, folder)


def main() -> None:
    """Prints a row for each file and the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*")
    parser.add_argument("--wild", type=Path, default=ROOT.parent / "shared" / "wild")
    given = parser.parse_args()
    counts = Counter[str]()
    for name, row in rows(given.wild, given.folders):
        counts[row.word] += 1
        print(f"{name} | {row.name} | {row.word} | {row.way} | {row.said[:700]}", flush=True)
    print(dict(counts))


if __name__ == "__main__":
    main()
