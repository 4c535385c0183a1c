#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Stacks PNG images of equal size vertically in one image: contact_sheet.py SHEET.png IMAGE.png..."""
import os
import sys

try:
    import numpy
    from matplotlib import image
except ImportError:
    sys.exit(f"contact_sheet.py: {sys.executable} has no matplotlib; on Debian: apt-get install python3-matplotlib")


def sheet(paths):
    """The images as one array, rows x columns x RGB."""
    try:
        images = [image.imread(path)[..., :3] for path in paths]
    except OSError as error:
        sys.exit(f"contact_sheet.py: {error}")
    if len({pixels.shape for pixels in images}) != 1:
        sys.exit("contact_sheet.py: the images differ in size; give images of one size")
    return numpy.concatenate(images)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: contact_sheet.py SHEET_PNG IMAGE_PNG...")
    pixels = numpy.ascontiguousarray(sheet(sys.argv[2:]))  # all images before writing
    image.imsave(sys.argv[1] + ".tmp", pixels, format="png")
    os.replace(sys.argv[1] + ".tmp", sys.argv[1])
