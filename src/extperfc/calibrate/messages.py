"""Images and calibrations of ROS messages as arrays; the messages' types are not imported."""

import cv2
import numpy

from extperfc.calibrate import views

# encoding: channels, conversion to BGR (None: as it is)
ENCODINGS = {
    "mono8": (1, None),
    "8UC1": (1, None),
    "bgr8": (3, None),
    "8UC3": (3, None),
    "rgb8": (3, cv2.COLOR_RGB2BGR),
    "bgra8": (4, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, cv2.COLOR_RGBA2BGR),
    "bayer_rggb8": (1, cv2.COLOR_BayerBG2BGR),
    "bayer_bggr8": (1, cv2.COLOR_BayerRG2BGR),
    "bayer_gbrg8": (1, cv2.COLOR_BayerGR2BGR),
    "bayer_grbg8": (1, cv2.COLOR_BayerGB2BGR)
}


def image_of_message(message):
    """BGR or grey image of a sensor_msgs/Image or CompressedImage. Raises views.ViewsError."""
    if message._type == "sensor_msgs/CompressedImage":
        image = cv2.imdecode(numpy.frombuffer(message.data, numpy.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise views.ViewsError(f"an image in the format '{message.format}' cannot be decoded")
        return image
    if message.encoding not in ENCODINGS:
        raise views.ViewsError(f"images are {message.encoding}: a colour or grey image with 8 bits is needed "
                               f"({', '.join(sorted(ENCODINGS))})")
    channels, conversion = ENCODINGS[message.encoding]
    rows = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)
    image = rows[:, :message.width * channels].reshape(message.height, message.width, channels)
    if conversion is not None:
        return cv2.cvtColor(image, conversion)
    return numpy.ascontiguousarray(image[:, :, 0] if channels == 1 else image)


def camera_of_message(message):
    """The views.Camera of a sensor_msgs/CameraInfo. Raises views.ViewsError."""
    return views.Camera(message.width, message.height, numpy.array(message.K, float).reshape(3, 3),
                        numpy.array(message.D, float), message.distortion_model or "plumb_bob")
