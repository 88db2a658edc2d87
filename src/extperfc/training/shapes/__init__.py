"""The default detector of cones, cubes and spheres: its network, recipe and evaluation."""
CLASSES = ('cone', 'cube', 'sphere')
WIDTH, HEIGHT = 512, 384  # input of the exported network [px]; more than the recipe's last size, for small objects
PAD = 114  # grey beside an image of another aspect
