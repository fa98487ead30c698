"""Screenshots of the page of `prp-gym view` for the documentation: a part of `make frames`.

They need the extra `view` and Chromium.
"""

import threading
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.viewer import Viewer
from tests.support.chromium import chromium
from tests.support.viewing_sessions import controller_session

FOLDER = Path(__file__).parent / "images"
TASK, CONTROLLER, SEED = "PRP-Force-v0", "parallel_force_position", 4
SHOWN = 500  # steps of the episode
SIZES = {"view_desktop": (1280, 800, False), "view_phone": (390, 844, True)}
"""Width and height of the browser [pixels], and whether it is that of a phone."""

_DRAWN = 20.0  # s, for a browser that draws by software, of which a notice warns
_CLOSE = "document.querySelectorAll('[class*=Notification] button').forEach(button => button.click())"


def main() -> None:
    """Write the screenshots."""
    from prp_gym.viewing.web.page import Page
    from prp_gym.viewing.web.server import serving

    viewer = Viewer(controller_session(TASK, CONTROLLER))
    viewer.session.reset(SEED)
    viewer.session.advance(SHOWN)
    viewer.session.pause()
    with serving("127.0.0.1", 0, f"prp_gym: {TASK}") as server, TemporaryDirectory() as folder:
        page = Page(server, viewer, PolicyCatalogue(TASK, 500.0, viewer.session.source))
        threading.Thread(target=viewer.run, args=(page,), daemon=True).start()
        for name, (width, height, phone) in SIZES.items():
            target = FOLDER / f"{name}.png"
            with chromium(Path(folder) / name) as tab:
                tab.open(f"http://127.0.0.1:{server.get_port()}", width, height, phone)
                tab.wait_for("document.querySelectorAll('canvas').length > 0")
                time.sleep(_DRAWN)
                tab.evaluate(_CLOSE)
                time.sleep(1.0)
                tab.screenshot(target)
            with Image.open(target) as image:
                image.convert("RGB").quantize(255).save(target, optimize=True)


if __name__ == "__main__":
    main()
