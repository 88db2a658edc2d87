"""What a run was made from, so that it can be repeated."""

import hashlib
import importlib.metadata
import pathlib
import platform
import subprocess

LIBRARIES = ("numpy", "torchvision", "opencv", "Pillow", "PyYAML", "matplotlib", "pycocotools")


def git_version():
    """Commit of the checkout this package lies in, with "-dirty" when it was changed; None outside a checkout."""
    here = pathlib.Path(__file__).resolve().parent
    described = subprocess.run(
        ["git", "-C", str(here), "describe", "--always", "--dirty", "--abbrev=40", "--exclude", "*"],
        capture_output=True,
        text=True)
    return described.stdout.strip() or None if described.returncode == 0 else None


def package_version():
    """Version in package.xml; None in an install space without one."""
    for folder in pathlib.Path(__file__).resolve().parents:
        file = folder / "package.xml"
        if file.exists():
            return file.read_text().split("<version>", 1)[1].split("</version>", 1)[0]
    return None


def library_versions():
    """{name: version} of what computes."""
    import cv2
    import torch
    versions = {"python": platform.python_version(), "torch": torch.__version__, "opencv": cv2.__version__}
    for name in LIBRARIES:
        try:
            versions.setdefault(name, importlib.metadata.version(name))
        except importlib.metadata.PackageNotFoundError:
            continue
    if torch.cuda.is_available():
        versions["cuda"] = torch.version.cuda
        versions["gpu"] = torch.cuda.get_device_name()
    return versions


def sha256_of(file):
    """SHA-256 of a file in hexadecimal digits."""
    return hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()


def describe(experiment, datasets, checksums, processes):
    """Everything that decides about the weights, for JSON. datasets, checksums: by split."""
    import torch
    return {
        "extperfc": package_version(), "git": git_version(), "libraries": library_versions(),
        "experiment": experiment.as_dict(),
        "data_sha256": checksums,
        "images": {split: len(dataset) for split, dataset in datasets.items()},
        "source_sha256": sha256_of(experiment.source) if experiment.source else None,
        "processes": processes.world, "device": str(processes.device), "threads": torch.get_num_threads()}
