#!/usr/bin/python3
"""The "display" of a headless LinuxCNC: runs one program and logs every servo cycle.

LinuxCNC starts it in the session's folder under the system's Python, which has the modules `linuxcnc` and `hal` and
no modules of hexcite:

    driver.py -ini INI PROGRAM TIME_LIMIT OVERRIDE

It enables and homes the machine, runs PROGRAM in automatic mode for at most TIME_LIMIT seconds on the wall, with the
feed override at OVERRIDE, and leaves

    samples.f64   one row a cycle, float64: number of the cycle, then the channels of the sampler
    status.json   outcome ("done", "error", "disabled", "paused", "time limit"), LinuxCNC's messages, counts

Exit code 0: the program ran to its end; 1: it did not.
"""

import argparse
import array
import json
import subprocess
import sys
import threading
import time

import hal
import linuxcnc

POLL = 0.003  # [s] between two reads of LinuxCNC's state
FETCH = 0.002  # [s] between two reads of the queue of logged cycles
REST = 0.02  # [s] for which the standstill after the program is logged
START_LIMIT = 40.0  # [s] for each step of starting; they take tenths of a second, on a very busy computer seconds
STATUS_LIMIT = 10.0  # [s] reading the state fails while it is being written; that passes when the writer goes on


def fetch(queue, values, finished):
    """Fetches the logged cycles, in a thread of its own; `halsampler` would print them with six digits only."""
    while True:
        last = finished.is_set()
        while queue.readable:
            row = queue.read()
            values.append(queue.sampleno)
            values.extend(row)
        if last:
            return
        time.sleep(FETCH)


class Session:
    """Commands, state and messages of LinuxCNC."""

    def __init__(self):
        self.command, self.state, self._channel = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
        self.errors, self.messages = [], []

    def look(self):
        start = time.monotonic()
        while True:
            try:
                self.state.poll()
                break
            except linuxcnc.error:
                if time.monotonic() - start > STATUS_LIMIT:
                    raise RuntimeError("milltask is gone") from None
                time.sleep(POLL)
        while True:
            message = self._channel.poll()
            if not message:
                return
            kind, text = message
            is_error = kind in (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR)
            (self.errors if is_error else self.messages).append(text.strip())

    def tell(self, command, *arguments):
        """Gives a command and waits until it is carried out: the next one would take its place."""
        command(*arguments)
        if self.command.wait_complete(START_LIMIT) == -1:
            raise RuntimeError(f"{command.__name__} was not carried out within {START_LIMIT:g} s")

    def wait(self, reached, step):
        start = time.monotonic()
        self.look()
        while not reached():
            if self.errors or time.monotonic() - start > START_LIMIT:
                raise RuntimeError(step)
            time.sleep(POLL)
            self.look()

    def prepare(self, program, joints, override):
        """Enables and homes the machine, turns the feed override and opens the program."""
        command, state = self.command, self.state
        self.tell(command.state, linuxcnc.STATE_ESTOP_RESET)
        self.tell(command.state, linuxcnc.STATE_ON)
        self.wait(lambda: state.task_state == linuxcnc.STATE_ON, "the machine cannot be enabled")
        self.tell(command.mode, linuxcnc.MODE_MANUAL)
        self.tell(command.teleop_enable, 0)
        command.home(-1)
        self.wait(lambda: all(state.homed[:joints]), "the joints cannot be homed")
        self.tell(command.teleop_enable, 1)
        self.wait(lambda: state.motion_mode == linuxcnc.TRAJ_MODE_TELEOP, "the axes cannot be moved together")
        self.tell(command.feedrate, override)
        self.tell(command.mode, linuxcnc.MODE_AUTO)
        self.tell(command.program_open, program)

    def run(self, time_limit):
        """Runs the open program; returns the outcome."""
        state = self.state
        start = time.monotonic()
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        serial = self.command.serial
        self.wait(lambda: state.echo_serial_number == serial, "the program cannot be started")
        while True:
            if self.errors:
                return "error"
            if state.task_state != linuxcnc.STATE_ON:
                return "disabled"
            if state.interp_state == linuxcnc.INTERP_PAUSED:
                return "paused"
            if state.interp_state == linuxcnc.INTERP_IDLE and state.queue == 0 and state.inpos:
                return "done"
            if time.monotonic() - start > time_limit:
                return "time limit"
            time.sleep(POLL)
            self.look()

    def shut_down(self):
        self.tell(self.command.abort)
        self.tell(self.command.state, linuxcnc.STATE_OFF)
        self.tell(self.command.state, linuxcnc.STATE_ESTOP)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("-ini", required=True)
    parser.add_argument("program")
    parser.add_argument("time_limit", type=float)
    parser.add_argument("override", type=float)
    arguments = parser.parse_args()
    session = Session()
    settings = linuxcnc.ini(arguments.ini)
    channels = settings.find("HEXCITE", "SAMPLER")
    component = hal.component("hexcite")
    component.newpin("record", hal.HAL_BIT, hal.HAL_OUT)
    component.ready()
    queue = hal.stream(component, hal.sampler_base, channels)
    subprocess.run(["halcmd", "net", "record", "hexcite.record", "sampler.0.enable"], check=True)
    values, width, finished = array.array("d"), 1 + len(channels), threading.Event()
    thread = threading.Thread(target=fetch, args=(queue, values, finished), daemon=True)  # ends with a killed driver

    def count():
        """Number of cycles that were logged so far, those in the queue included."""
        waiting = queue.depth
        return waiting + len(values) // width

    started = 0
    try:
        session.prepare(arguments.program, int(settings.find("KINS", "JOINTS")), arguments.override)
        thread.start()
        component["record"] = True
        started = count()
        outcome = session.run(arguments.time_limit)
    except RuntimeError as failure:
        outcome = "error"
        session.errors.append(str(failure))
    ended = count()
    if thread.is_alive():
        time.sleep(REST)
        component["record"] = False
        time.sleep(REST)
        finished.set()
        thread.join()
    with open("samples.f64", "wb") as out:
        values.tofile(out)
    numbers = values[::width]
    status = {
        "outcome": outcome,
        "version": linuxcnc.version,
        "errors": session.errors,
        "messages": session.messages,
        "line": next((int(line) for line in values[1::width][::-1] if line), 0),  # the last one in motion
        "started": started,
        "ended": ended,
        "samples": count(),
        "lost": int(numbers[-1] - numbers[0]) + 1 - count() if numbers else 0,
    }
    with open("status.json", "w") as out:
        json.dump(status, out)
    session.shut_down()
    return 0 if outcome == "done" else 1


if __name__ == "__main__":
    sys.exit(main())
