"""Makes the JPEG images of this folder, with Pillow: a grey one, and two with a brown and a blue half."""

from pathlib import Path

from PIL import Image

FOLDER = Path(__file__).parent

Image.new("L", (8, 8), 51).save(FOLDER / "grey.jpg", quality=95, optimize=True)
halves = Image.new("RGB", (16, 8), (200, 100, 50))
halves.paste((20, 40, 220), (8, 0, 16, 8))
for name, progressive in [("baseline", False), ("progressive", True)]:
    halves.save(FOLDER / f"{name}.jpg", quality=90, subsampling=0, optimize=True, progressive=progressive)
