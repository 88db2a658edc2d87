"""Equal and nearly equal images: checksums, perceptual hashes, groups.

The hash is the sign pattern of the lowest 8 x 8 cosine coefficients of a 32 x 32 grey thumbnail against their median
(Zauner, "Implementation and benchmarking of perceptual image hash functions", 2010, section 3.2).
"""

import collections
import hashlib
import itertools
import typing

import cv2
import numpy as np

from .dataset import DataError

MAX_DISTANCE = 4  # differing bits of 64
MAX_DIFFERENCE = 6.0  # grey levels between thumbnails, in the mean; guards against hashes that agree by chance
BANDS = ((0, 13), (13, 13), (26, 13), (39, 13), (52, 12))  # with at most four differing bits one of five bands is equal


class Fingerprint(typing.NamedTuple):
    """sha256 of the file, 64-bit perceptual hash, thumbnail uint8 [32, 32], width and height of the image in pixels."""

    sha256: str
    phash: int
    thumbnail: np.ndarray
    size: typing.Tuple[int, int]


def fingerprint(file):
    """Fingerprint of an image file; DataError when it cannot be read."""
    content = file.read_bytes()
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE) if content else None
    if image is None:
        raise DataError(f"{file}: cannot be read as an image")
    thumbnail = cv2.resize(image, (32, 32), interpolation=cv2.INTER_AREA)
    return Fingerprint(hashlib.sha256(content).hexdigest(), phash(thumbnail), thumbnail, image.shape[::-1])


def phash(thumbnail):
    """64-bit perceptual hash of a grey image uint8 [32, 32]."""
    low = cv2.dct(thumbnail.astype(np.float32))[:8, :8].flatten()
    bits = low > np.median(low[1:])
    return int("".join("1" if bit else "0" for bit in bits), 2)


def near_pairs(prints):
    """Pairs (i, j), i < j, of fingerprints that look alike; equal files are among them."""
    buckets = collections.defaultdict(list)
    for index, one in enumerate(prints):
        for band, (shift, width) in enumerate(BANDS):
            buckets[band, (one.phash >> shift) & ((1 << width) - 1)].append(index)
    seen = set()
    for members in buckets.values():
        seen.update(itertools.combinations(members, 2))
    return sorted(pair for pair in seen if are_alike(prints[pair[0]], prints[pair[1]]))


def are_alike(one, other):
    """Whether two images differ by little more than compression, noise or a few pixels of motion."""
    if bin(one.phash ^ other.phash).count("1") > MAX_DISTANCE:
        return False
    return float(np.abs(one.thumbnail.astype(np.int16) - other.thumbnail).mean()) <= MAX_DIFFERENCE


def groups_of(count, pairs):
    """Connected components of `count` items as lists of indices, in the order of their first members."""
    parent = list(range(count))

    def root(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i
    for i, j in pairs:
        low, high = sorted((root(i), root(j)))
        parent[high] = low
    groups = collections.defaultdict(list)
    for i in range(count):
        groups[root(i)].append(i)
    return list(groups.values())
