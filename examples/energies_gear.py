"""energies_gear: a motor drives a train of three wheels with 12, 30 and 18 teeth.

What it shows: `@stark.joint`, a joint of your own between bodies that turn on hinges; an energy of a frame as
the motor; angles that count turns, rates, reactions.
The check: angles in the ratio of the teeth after many turns; the closed form of the acceleration of the first
wheel, torque / sum of I_k (z_1 / z_k)^2; no power is lost in the gears. Writes out/energies_gear.png.

    python examples/energies_gear.py            prints turns and power, then "check: passed"
"""

import numpy as np
import pictures

import stark

TEETH, MODULE, DENSITY = np.array([12, 30, 18]), 0.004, 2700.0  # diameter per tooth [m], [kg/m^3]
TORQUE, STEP, EARLY, END = 0.04, 2e-3, 0.02, 1.2  # [N m], [s]


@stark.joint
def gear(a: stark.Frame, b: stark.Frame, teeth_a: float, teeth_b: float):
    """Wheels about their z axes that mesh as they stand at time 0."""

    def phase(origin_a, origin_b, axes_a, axes_b):
        """Angles between the line of centres and the wheels, in teeth."""
        e = stark.normalized(origin_b - origin_a)
        angles = [stark.atan2(axes.column(1) @ e, axes.column(0) @ e) for axes in (axes_a, axes_b)]
        return teeth_a * angles[0] + teeth_b * angles[1]

    slip = phase(a.origin, b.origin, a.axes, b.axes) - phase(a.origin0, b.origin0, a.axes0, b.axes0)
    # An angle jumps by 2 pi once a turn, the phase by that times a whole number of teeth: no slip at all.
    return stark.hold(direction=stark.atan2(stark.sin(slip), stark.cos(slip)) / teeth_b)


@stark.energy
def motor(f: stark.Frame, h: stark.TimeStep, torque: stark.Vec3):
    """Minus the work [J] of a torque [N m] in the time step."""
    return -h * (torque @ f.angular_velocity)


def build():
    scene, wheels, hinges = stark.Scene(), [], []
    radii = 0.5 * MODULE * TEETH
    for k, color in enumerate((pictures.RED, pictures.BLUE, pictures.YELLOW)):
        mesh = pictures.toothed_wheel(TEETH[k], radii[k], thickness=0.01, gap_at_zero=k == 1)
        center = (2 * radii[:k].sum() + radii[k], 0, 0)  # each wheel touches the one before
        wheels.append(scene.add_rigid(mesh, density=DENSITY, position=center, color=color))
        hinges.append(scene.add_hinge(None, wheels[k], anchor=center, axis=(0, 0, 1)))
    frames, teeth = [wheel.frame() for wheel in wheels], [float(z) for z in TEETH]
    pairs = [(frames[k], frames[k + 1], teeth[k], teeth[k + 1]) for k in (0, 1)]
    gears = [scene.add_joint(gear, a, b, teeth_a=m, teeth_b=n) for a, b, m, n in pairs]
    scene.add(motor(frames[0], torque=(0, 0, TORQUE)))
    return stark.Simulation(scene, time_step=STEP, gravity=(0, 0, 0)), wheels, hinges, gears


def main():
    sim, wheels, hinges, gears = build()
    sim.run_until(EARLY)
    inertia = np.array([wheel.inertia[2, 2] for wheel in wheels]) @ (TEETH[0] / TEETH) ** 2
    # Implicit Euler brakes a rotation by about w^3 h, which has cost 1.5e-4 of the speed so far.
    assert abs(hinges[0].rates["angle"] * inertia / (TORQUE * EARLY) - 1) < 5e-4, "not the closed form"
    sim.run_until(END)
    passed = [hinge.angle * z for hinge, z in zip(hinges, TEETH, strict=True)]
    print("turns:", passed / TEETH / (2 * np.pi))
    for k, joint in enumerate(gears):
        # The tolerance of joints is 1e-5 rad for the wheel b, however many teeth have passed.
        assert abs(passed[k] + passed[k + 1]) < 1e-5 * TEETH[k + 1], "a gear slips"
        on_b = joint.reaction
        on_a = -on_b.torque - np.cross(wheels[k + 1].position - wheels[k].position, on_b.force)
        power = on_a[2] * hinges[k].rates["angle"], on_b.torque[2] * hinges[k + 1].rates["angle"]
        print(f"power of gear {k + 1}: {power[0]:.6f} W, {power[1]:.6f} W")
        # Rates are held as angles are; measured: 1e-13.
        assert abs(sum(power)) < 1e-6 * power[1], "power is lost"
    print(pictures.save("energies_gear", map(pictures.snapshot, wheels), azimuth=-84, elevation=40))
    print("check: passed")


if __name__ == "__main__":
    main()
