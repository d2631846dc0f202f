"""Loads: pressure inside closed surfaces, pressure and traction on faces, forces on points, torques on rigid
bodies. They are energies like those of users: ``scene.add_pressure(ball, 200.0)`` returns the handle of one,
whose value may change at any time."""
