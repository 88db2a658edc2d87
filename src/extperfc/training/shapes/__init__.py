"""The default detector of cones, cubes and spheres: its network, recipe and evaluation."""
CLASSES = ('cone', 'cube', 'sphere')
WIDTH, HEIGHT = 384, 288  # input of the network [px]
PAD = 114  # grey beside an image of another aspect
