"""Images as readers with deuteranopia see them: `python -m docs.colour_vision IMAGE.png ...`.

Source: G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, A Physiologically-based Model for Simulation of
    Color Vision Deficiency, IEEE TVCG 15(6), 2009: deuteranomaly of severity 1.0, applied to linear RGB.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

DEUTERANOPIA = np.array(
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]
)


def simulate(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An image (..., 3) in sRGB as it is seen with deuteranopia."""
    encoded = image / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ DEUTERANOPIA.T, 0.0, 1.0)
    again = np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055)
    result: NDArray[np.uint8] = np.rint(255.0 * again).astype(np.uint8)
    return result


def main() -> None:
    """Write each image as it is seen, beside it with `-deuteranopia` in its name."""
    for name in sys.argv[1:]:
        path = Path(name)
        with Image.open(path) as image:
            seen = simulate(np.asarray(image.convert("RGB")))
        Image.fromarray(seen).save(path.with_stem(f"{path.stem}-deuteranopia"))


if __name__ == "__main__":
    main()
