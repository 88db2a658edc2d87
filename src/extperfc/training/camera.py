"""What light and a camera do to an image: exposure, white balance, blur, noise, compression."""
import cv2
import numpy as np

from .textures import noise, pick


def _defocus(rng, image, depth):
    """Blurs what lies behind a random distance."""
    far = np.nan_to_num(depth, posinf=1e3)
    limit = np.percentile(far[::4, ::4], rng.uniform(30, 80))
    soft = cv2.GaussianBlur(np.float32(far > limit * 1.05), (0, 0), 1.0)[..., None]
    blurred = cv2.GaussianBlur(image, (0, 0), rng.uniform(1.5, 6) * image.shape[1] / 448)
    return image + soft * (blurred - image)


def _blur(rng, image):
    """Gaussian or motion blur of the whole image."""
    kind, unit = rng.random(), image.shape[1] / 448
    if kind < 0.35:
        return cv2.GaussianBlur(image, (0, 0), unit * rng.uniform(0.4, 1.6))
    if kind < 0.47:
        size, angle = int(unit * rng.uniform(3, 11)) | 1, rng.uniform(0, np.pi)
        kernel = np.zeros((size, size), np.float32)
        reach = size // 2 * np.array([np.cos(angle), np.sin(angle)])
        cv2.line(kernel, tuple(np.int32(np.round(size // 2 - reach))), tuple(np.int32(np.round(size // 2 + reach))), 1.0)
        return cv2.filter2D(image, -1, kernel / kernel.sum())
    if kind < 0.53:
        small = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        return cv2.resize(small, image.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    return image


def _lighting(rng, shape):
    """A slow change of light over the image, with vignetting."""
    height, width = shape[:2]
    gain = 1 + rng.uniform(0, 0.3) * noise(rng, 32, 2, 2)
    ys, xs = np.mgrid[-1:1:32j, -1:1:32j]
    gain = gain * (1 - rng.uniform(0, 0.35) * (xs ** 2 + ys ** 2) / 2)
    return cv2.resize(np.float32(np.clip(gain, 0.3, 1.7)), (width, height))[..., None]


def apply_camera_effects(rng, linear, depth):
    """Linear light (H, W, 3) to an 8-bit RGB image as a random camera would take it."""
    image = linear * _lighting(rng, linear.shape)
    sample = image[::5, ::5].mean(2)
    level = np.exp(rng.normal(np.log(0.28), 0.33))
    image = image * (level / (np.mean(np.minimum(sample, np.percentile(sample, 95))) + 1e-3))
    image = image * np.exp(rng.normal(0, 0.09, 3)).astype(np.float32)
    if rng.random() < 0.15:
        image = _defocus(rng, image, depth)
    image = _blur(rng, image)
    image = np.sqrt(np.clip(image, 0, 1))
    if rng.random() < 0.3:
        image = image * (2 - image) if rng.random() < 0.5 else image * image * (3 - 2 * image)
    if rng.random() < 0.4:
        grey = image.mean(2, keepdims=True)
        image = grey + (image - grey) * pick(rng, (0.0, rng.uniform(.2, .9), rng.uniform(.6, 1), rng.uniform(1, 1.5)))
    if rng.random() < 0.25:
        low = rng.uniform(0, 0.3)
        image = low + image * rng.uniform(0.4, 1 - low)
    return _sensor(rng, image)


def _sensor(rng, image):
    """Adds sensor noise, quantises and compresses."""
    sigma = abs(rng.normal(0, 0.013))
    if sigma > 0.004:
        image = image + sigma * rng.standard_normal(image.shape, dtype=np.float32)
    out = np.uint8(np.clip(image * 255 + 0.5, 0, 255))
    if rng.random() < 0.35:
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(25, 90))]
        out = cv2.imdecode(cv2.imencode('.jpg', out, quality)[1], cv2.IMREAD_COLOR)
    return out
