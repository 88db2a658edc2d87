"""Files that are either whole or absent, also after a crash, a kill or a full disk."""

import errno
import os
import pathlib
import tempfile


class WriteError(Exception):
    """A file could not be written; the text names it and the remedy. What stood there before is untouched."""


def _reason(file, error):
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"the disk is full: cannot write {file}; free some space, or choose a folder on another disk"
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return f"no permission to write {file}: change the owner or mode of its folder, or choose another one"
    return f"cannot write {file}: {error.strerror or error}; is its folder still there?"


def _write_beside(file, data):
    """A temporary file with these bytes on the disk, in the folder of `file`."""
    handle, name = tempfile.mkstemp(prefix=f".{file.name}.", suffix=".partial", dir=file.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fchmod(stream.fileno(), 0o666 & ~_umask())
            os.fsync(stream.fileno())
    except BaseException:
        os.unlink(name)
        raise
    return name


def _umask():
    """The mask of new files; reading it needs to set it."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def replace_file(file, data):
    """Writes bytes under a name, in place of what stood there. Raises WriteError."""
    file = pathlib.Path(file)
    try:
        name = _write_beside(file, data)
        try:
            os.replace(name, file)
        except OSError:
            os.unlink(name)
            raise
    except OSError as error:
        raise WriteError(_reason(file, error)) from error


def create_file(file, data):
    """Writes bytes under a name that is free. Raises FileExistsError when it is not, and WriteError."""
    file = pathlib.Path(file)
    try:
        name = _write_beside(file, data)
        try:
            _link_or_rename(name, file)
        finally:
            pathlib.Path(name).unlink(missing_ok=True)
    except FileExistsError:
        raise
    except OSError as error:
        raise WriteError(_reason(file, error)) from error


def _link_or_rename(name, file):
    """A hard link never replaces a file. File systems without them (FAT) are asked before the rename."""
    try:
        os.link(name, file)
    except FileExistsError:
        raise
    except OSError as error:
        if error.errno not in (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK):
            raise
        if file.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(file)) from None
        os.replace(name, file)


def make_folder(folder):
    """Makes a folder with those above it. Raises WriteError."""
    try:
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(_reason(folder, error)) from error
