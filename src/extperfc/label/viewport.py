"""Where an image lies in a window: zoom and pan, without Qt."""

MARGIN = 12  # px of the window around a fitted image
MAX_SCALE = 40.0  # window pixels per image pixel
KEPT = 60  # px of the image that panning leaves in the window


class Viewport:
    """A transform view = image * scale + offset. Sizes and points in pixels; `scale` is window pixels per image
    pixel."""

    def __init__(self):
        self.image, self.view = (1, 1), (1, 1)
        self.scale, self.x, self.y = 1.0, 0.0, 0.0
        self.fitted = True  # follows changes of the window's size

    def set_image(self, width, height):
        """Another image. One of the same size keeps zoom and position, so that a series is looked at in one place."""
        if (width, height) != self.image:
            self.image, self.fitted = (max(width, 1), max(height, 1)), True
        self._update()

    def set_view(self, width, height):
        """Another size of the window."""
        self.view = (max(width, 1), max(height, 1))
        self._update()

    def fit(self):
        """Shows the whole image."""
        self.fitted = True
        self._update()

    def zoom(self, factor, at=None):
        """Enlarges by a factor about a point of the window, by default its centre."""
        x, y = at or (self.view[0] / 2, self.view[1] / 2)
        low = min(0.1, self._fitting_scale())
        scale = max(low, min(self.scale * factor, MAX_SCALE))
        factor, self.scale, self.fitted = scale / self.scale, scale, False
        self.x, self.y = x - (x - self.x) * factor, y - (y - self.y) * factor
        self._keep_in_view()

    def pan(self, dx, dy):
        """Moves the image by pixels of the window."""
        self.x, self.y, self.fitted = self.x + dx, self.y + dy, False
        self._keep_in_view()

    def to_image(self, x, y):
        return (x - self.x) / self.scale, (y - self.y) / self.scale

    def to_view(self, x, y):
        return x * self.scale + self.x, y * self.scale + self.y

    def _fitting_scale(self):
        return max(min((self.view[i] - 2 * MARGIN) / self.image[i] for i in (0, 1)), 0.01)

    def _update(self):
        if not self.fitted:
            self._keep_in_view()
            return
        self.scale = self._fitting_scale()
        self.x, self.y = ((self.view[i] - self.image[i] * self.scale) / 2 for i in (0, 1))

    def _keep_in_view(self):
        low = [KEPT - self.image[i] * self.scale for i in (0, 1)]
        self.x = max(low[0], min(self.x, self.view[0] - KEPT))
        self.y = max(low[1], min(self.y, self.view[1] - KEPT))
