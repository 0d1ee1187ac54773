"""Predicted sensor forces: two derivations that share nothing agree, and a limit that is passed is named."""

from itertools import accumulate

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.schema import Case
from cases.sensors import RigidBody, together
from identification.limits.proof import prove
from identification.limits.sensor_loads import Loads
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from identification.model.parameters import body_parameters
from identification.motion.motion import Standstill, rotation_motion
from tests.helpers import HOME, Harmonic
from tests.postprocessors.changed_case import changed


def test_newton_euler_and_the_regressor_say_the_same(hexapod_case: Case):
    motion = Harmonic(seed=4).at(np.linspace(0.1, 2.9, 40))
    model = identification_model(hexapod_case, 6)
    matrices = over_samples(model.coordinate_regressor, motion.coordinates, motion.rates, motion.accelerations)[0]
    found = Loads.of(hexapod_case).forces(motion, rotation_motion(motion), motion.accelerations[:, :3])
    for body, forces in zip(hexapod_case.bodies, np.hsplit(found, len(hexapod_case.bodies)), strict=True):
        known = body_parameters(body)
        expected = matrices @ np.array([known.get(name, 0.0) for name in model.names])
        assert forces == pytest.approx(expected, rel=1e-9, abs=1e-6)


def test_the_reference_payloads_are_those_of_table_7(hexapod_case: Case):
    """Masses of section 8; the centres of gravity of the sum follow the table's where the masses do (within 1.5 mm)."""
    start = RigidBody(
        mass_kg=33.78, centre_of_gravity_mm=(0.0, 0.0, 108.93), inertia_kg_m2=hexapod_case.nominal.inertia_kg_m2
    )
    sums = list(accumulate(hexapod_case.payloads.weights, together, initial=start))[1:]
    assert [b.mass_kg for b in sums[:3]] == pytest.approx([53.71, 73.64, 93.57], abs=0.01)
    table = (98.54 / 0.999, 110.65 / 0.999, 129.35 / 0.988)
    assert [b.centre_of_gravity_mm[2] for b in sums[:3]] == pytest.approx(table, abs=1.5)


def test_together_is_what_two_bodies_weigh_and_resist_about_any_point(hexapod_case: Case):
    first, second = hexapod_case.nominal, hexapod_case.payloads.weights[2]
    both, parts = body_parameters(together(first, second)), [body_parameters(b) for b in (first, second)]
    for name, value in both.items():
        assert value == pytest.approx(parts[0][name] + parts[1][name], abs=1e-9)


def test_sensors_that_are_too_weak_for_a_payload_are_named(hexapod_case: Case):
    weak = changed(hexapod_case, sensors__range_N=300.0)
    report = prove(Standstill(HOME, 0.01), weak, 100.0)
    (worst,) = (c for c in report.violations if c.kind == "sensor force")
    assert "5 payloads" in worst.name
    assert worst.limit == pytest.approx(np.sign(worst.worst) * 240.0)


def test_more_payloads_than_the_case_has_are_refused(hexapod_case: Case):
    with pytest.raises(CaseError, match=r"payloads\.weights: .*\b5; 6\b"):
        hexapod_case.body(6)
