"""Text files that are whole or not there."""

import os


def write_text_atomically(text, file):
    """Writes beside the target and renames."""
    partial = file.with_name(f".{file.name}.partial")
    partial.write_text(text)
    os.replace(partial, file)
