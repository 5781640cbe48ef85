"""The rig's two-link plant against MuJoCo: the same rig, another engine's mechanics and friction.

The MuJoCo model is in minimal coordinates, the two joints of the arm, so that the pin at the handle is
exact. The robot hangs on two spatial tendons, from the handle to sites very far along x and y: a tendon has
its own mass (armature), damping, friction and motor along one direction, here off the axis by 1e-12 rad.
The plane is horizontal: no gravity. MuJoCo is driven by the torques that our plant held.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

import jointed_arms
import telespring as ts
from telespring import _core
from telespring._types import FloatArray

FAR = 1e11  # m; only the tendons' directions matter, their lengths do not
TICK = 1e-3  # s
#: With ten times the joint damping.
ARM: dict[str, Any] = {**jointed_arms.ARM, "joint_damping": [0.4, 0.3]}
ROBOT: dict[str, Any] = {"mass": [0.8334, 0.7257], "damping": [7.7257, 6.1], "coulomb": [0.0, 0.0]}


def rig_xml(robot: dict[str, Any], timestep: float, integrator: str) -> str:
    """Write the rig as MJCF.

    MuJoCo regularises friction: it lets a stuck axis creep and needs a time constant of two timesteps at
    least. With the solref and solimp below both vanish with the timestep.
    """

    def link(index: int, inner: str) -> str:
        mass, centre, inertia = (ARM[key][index] for key in ("link_mass", "link_centre", "link_inertia"))
        place = (*ARM["base"], 0.0) if index == 0 else (ARM["link_length"][0], 0.0, 0.0)
        return f"""
        <body pos="{place[0]} {place[1]} {place[2]}">
          <joint name="joint{index}" type="hinge" axis="0 0 1" damping="{ARM["joint_damping"][index]}"
                 armature="{ARM["rotor_inertia"][index]}"/>
          <inertial pos="{centre} 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
          {inner}
        </body>"""

    def tendon(index: int) -> str:
        return f"""
        <spatial name="axis{index}" armature="{robot["mass"][index]}" damping="{robot["damping"][index]}"
                 frictionloss="{robot["coulomb"][index]}" solreffriction="{2 * timestep} 1"
                 solimpfriction="0.9999 0.9999 0.001 0.5 2">
          <site site="far{index}"/><site site="handle"/>
        </spatial>"""

    handle = f'<site name="handle" pos="{ARM["link_length"][1]} 0 0"/>'
    motors = [f'<motor joint="joint{i}"/>' for i in range(2)] + [
        f'<motor tendon="axis{i}"/>' for i in range(2)
    ]
    return f"""
    <mujoco>
      <compiler angle="radian" inertiafromgeom="false" boundmass="0" boundinertia="0"/>
      <option timestep="{timestep}" gravity="0 0 0" integrator="{integrator}" tolerance="1e-14"
              iterations="200" cone="elliptic"/>
      <worldbody>
        <site name="far0" pos="{-FAR} 0 0"/><site name="far1" pos="0 {-FAR} 0"/>
        {link(0, link(1, handle))}
      </worldbody>
      <tendon>{tendon(0)}{tendon(1)}</tendon>
      <actuator>{"".join(motors)}</actuator>
    </mujoco>"""


def run_mujoco(
    robot: dict[str, Any],
    torque: FloatArray,
    robot_force: FloatArray,
    start: tuple[FloatArray, FloatArray],
    steps: int,
    integrator: str,
) -> FloatArray:
    """Positions of the handle after every tick, m, each in so many steps of MuJoCo."""
    model = mujoco.MjModel.from_xml_string(rig_xml(robot, TICK / steps, integrator))
    data = mujoco.MjData(model)
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "handle")
    data.qpos[:], data.qvel[:] = start
    positions = []
    for tick in range(len(torque) + 1):
        mujoco.mj_kinematics(model, data)
        positions.append(data.site_xpos[site, :2].copy())
        if tick < len(torque):
            data.ctrl[:2], data.ctrl[2:] = torque[tick], robot_force[tick]
            mujoco.mj_step(model, data, nstep=steps)
    return np.array(positions)


def joint_state(elbow_side: str, position: FloatArray, velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angles and rates of the joints, by the law of cosines."""
    l1, l2 = ARM["link_length"]
    x, y = position - np.array(ARM["base"])
    elbow = (1 if elbow_side == "right" else -1) * np.arccos(
        (x * x + y * y - l1 * l1 - l2 * l2) / (2 * l1 * l2)
    )
    shoulder = np.arctan2(y, x) - np.arctan2(l2 * np.sin(elbow), l1 + l2 * np.cos(elbow))
    s1, c1, s12, c12 = (f(a) for a in (shoulder, shoulder + elbow) for f in (np.sin, np.cos))
    jacobian = np.array([[-l1 * s1 - l2 * s12, -l2 * s12], [l1 * c1 + l2 * c12, l2 * c12]])
    return np.array([shoulder, elbow]), np.linalg.solve(jacobian, velocity)


def run_both(
    robot: dict[str, Any],
    hand_force: FloatArray,
    robot_force: FloatArray,
    velocity: FloatArray,
    steps: int,
    integrator: str,
    elbow: str = "right",
) -> tuple[_core.HandleMotion, FloatArray]:
    """Ours, and MuJoCo's positions under the torques that ours held."""
    position = np.array([-0.04 if elbow == "right" else 0.1, 0.02])
    arm = {**ARM, "elbow": elbow}
    ours = _core.simulate_handle(
        robot, arm, hand_force, robot_force, TICK, position.tolist(), velocity.tolist()
    )
    assert ours.status == "completed"
    start = joint_state(elbow, position, velocity)
    assert ours.torque is not None
    return ours, run_mujoco(robot, ours.torque, robot_force, start, steps, integrator)


@pytest.mark.parametrize("elbow", ["left", "right"])
def test_cross_fast_movement(elbow: str) -> None:
    t = np.arange(800) * TICK
    side = 1 if elbow == "right" else -1  # as the arm's mass couples x and y with this sign
    hand = np.stack([side * 45 * np.cos(18 * t), 40 * np.sin(15 * t)], axis=1)
    push = np.stack([side * 4 * np.sin(9 * t), -3 * np.cos(7 * t)], axis=1)
    off = []
    for steps in (1, 2, 4):
        ours, theirs = run_both(ROBOT, hand, push, np.array([0.0, -1.2]), steps, "RK4", elbow)
        off.append(np.abs(ours.position - theirs).max())
    speed = np.linalg.norm(ours.velocity, axis=1)
    assert speed.max() > 1.5
    assert np.median(speed) > 1.0
    # 2e-10 m at 1 ms over a way of 0.2 m: MuJoCo's Runge-Kutta error, as it falls with the fourth power of
    # its timestep (16 each time; 8 and 3 leave room for rounding near 1e-12)
    assert off[0] < 2e-10
    assert off[1] < off[0] / 8
    assert off[2] < off[1] / 3


def test_cross_stick_and_slip() -> None:
    rough = {**ROBOT, "coulomb": [1.2, 0.8]}
    t = np.arange(2000) * TICK
    hand = np.stack([2.2 * np.sin(5 * t), 1.6 * np.sin(3.3 * t)], axis=1)
    off = {}
    for steps in (5, 20, 80):
        ours, theirs = run_both(
            rough, hand, np.zeros_like(hand), np.array([0.2, -0.1]), steps, "implicitfast"
        )
        off[steps] = np.abs(ours.position - theirs).max()
        # first order: 0.06 mm at 0.2 ms, 4 µm at 12.5 µs, over ways of 55 and 25 mm
        assert off[steps] < 0.3 * TICK / steps
    assert off[80] < off[20] / 3 < off[5] / 9 * 2
    stuck = ours.velocity == 0
    changes = np.abs(np.diff(stuck.astype(int), axis=0)).sum(axis=0)
    assert (stuck.mean(axis=0) > 0.15).all(), "both axes are to stick for a while"
    assert (changes >= 5).all(), "both axes are to stick and start again"


def test_cross_the_arm_that_the_handle_feels() -> None:
    positions = np.random.default_rng(7).uniform(-0.1, 0.1, (20, 2))
    mass, damping = _core.arm_operator(ARM, positions)
    model = mujoco.MjModel.from_xml_string(
        rig_xml({"mass": [0, 0], "damping": [0, 0], "coulomb": [0, 0]}, TICK, "RK4")
    )
    data = mujoco.MjData(model)
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "handle")
    for row, position in enumerate(positions):
        data.qpos[:] = joint_state("right", position, np.zeros(2))[0]
        mujoco.mj_forward(model, data)
        inertia, jacobian = np.zeros((2, 2)), np.zeros((3, 2))
        mujoco.mj_fullM(model, data, inertia)
        mujoco.mj_jacSite(model, data, jacobian, None, site)
        inverse = np.linalg.inv(jacobian[:2])
        # 1e-12: rounding, times the condition of the Jacobian
        np.testing.assert_allclose(mass[row], inverse.T @ inertia @ inverse, rtol=1e-12, atol=1e-12)
        expected = inverse.T @ np.diag(ARM["joint_damping"]) @ inverse
        np.testing.assert_allclose(damping[row], expected, rtol=1e-12, atol=1e-11)


def test_law_a_misspelt_or_missing_value_is_named() -> None:
    def run(robot: dict[str, Any], arm: dict[str, Any], start: list[float]) -> None:
        _core.simulate_handle(robot, arm, [[0.0, 0.0]], [[0.0, 0.0]], TICK, start)

    for robot, arm, start, field in [
        (ROBOT, {**ARM, "link_lenght": [0.3, 0.3]}, [0.0, 0.0], "arm.link_lenght"),
        (ROBOT, {**ARM, "elbow": "up"}, [0.0, 0.0], "arm.elbow"),
        (ROBOT, {**ARM, "link_mass": [0.9, -0.4]}, [0.0, 0.0], "arm.link_mass[1]"),
        (ROBOT, {**ARM, "link_mass": "heavy"}, [0.0, 0.0], "arm.link_mass"),
        ({"mass": 0.8}, ARM, [0.0, 0.0], "handle.damping"),
        ({**ROBOT, "coulomb": -1.0}, ARM, [0.0, 0.0], "handle.coulomb"),
        (ROBOT, ARM, [0.0, 0.5], "arm.base"),
    ]:
        with pytest.raises(ts.InvalidInput) as refused:
            run(robot, arm, start)
        assert refused.value.field == field


def test_law_leaving_the_reach_ends_the_record() -> None:
    push = np.tile([0.0, 40.0], (2000, 1))
    found = _core.simulate_handle(ROBOT, ARM, 0 * push, push, TICK, [0.0, 0.1])
    assert found.status == "out of reach"
    ticks = len(found.position)
    assert found.ended_at == pytest.approx((ticks - 1) * TICK)
    assert ticks < 500
    assert all(len(getattr(found, name)) == ticks for name in ("velocity", "handle_force", "torque"))
    assert np.isfinite(found.position).all()
