"""A ball, a block of jelly and a towel to play with in a browser: drag a body; Ctrl-C ends it."""

from contextlib import suppress

import stark

scene = stark.Scene("play")
scene.default_friction = 0.4
scene.add_floor(3.0)
scene.add_solid(stark.mesh.tet_box((0.2, 0.2, 0.15), (6, 6, 5)), name="jelly", position=(0, 0, 0.077))
scene.add_sphere(0.05, name="ball", mass=0.6, position=(0.02, 0, 0.206))
scene.add_cloth(stark.mesh.grid(0.25, 0.25, cells=16), name="towel", position=(0, 0, 0.3))
stark.view.add_pulls(scene)

if __name__ == "__main__":
    with stark.Simulation(scene, time_step=0.01).view(contacts=True) as view:
        print(view.url)
        with suppress(KeyboardInterrupt):
            view.run()
