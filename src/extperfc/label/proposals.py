"""A network that works beside the window: loads a model folder and searches images in one thread."""

import concurrent.futures

from PyQt5.QtCore import QObject, pyqtSignal

from extperfc.label.boxes import without_known
from extperfc.label.folder import FolderError
from extperfc.label.model_folder import ModelError


class Proposer(QObject):
    """Proposes boxes for images. Only the newest request counts; older ones that have not begun are dropped."""

    proposed = pyqtSignal(str, list)  # name of the image, [(boxes.Box, score)]
    failed = pyqtSignal(str)  # what went wrong, for the user

    def __init__(self, parent=None):
        super().__init__(parent)
        self.model = None  # folder
        self._detector = None
        self._pool = concurrent.futures.ThreadPoolExecutor(1)
        self._pending = None

    def choose(self, model):
        """Takes a model folder; it is loaded at the first request."""
        self.model, self._detector = model, None

    def request(self, name, file, present):
        """Proposes boxes for the image in a file, apart from those that overlap the present ones."""
        if self._pending:
            self._pending.cancel()
        self._pending = self._pool.submit(self._run, self.model, name, file, tuple(present))

    def close(self):
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _run(self, model, name, file, present):
        try:
            self.proposed.emit(name, self._find(model, file, present))
        except (ModelError, FolderError) as error:
            self.failed.emit(str(error))

    def _find(self, model, file, present):
        import cv2  # slow to load, and not needed without a model

        from extperfc.label.detector import Detector
        if self._detector is None or self._detector[0] != model:
            self._detector = (model, Detector(model))
        image = cv2.imread(str(file), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
        if image is None:
            raise FolderError(f"OpenCV cannot read {file}")
        found = self._detector[1].propose(image)
        fresh = without_known([box for box, _ in found], present)
        return [(box, score) for box, score in found if box in fresh]
