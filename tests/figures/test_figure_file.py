"""Figures as files: the suffix chooses the kind, and equal figures give equal files."""

import io
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from PIL import Image

from prp_gym.errors import InvalidValueError
from prp_gym.figures.figure_file import SUFFIXES, figure_content, new_figure, write_figure
from prp_gym.figures.notebook_figure import NotebookFigure


def figure() -> NotebookFigure:
    made = new_figure(3.0, 2.0)
    axes = made.subplots()
    axes.plot([0.0, 1.0], [0.0, 1.0])
    axes.set_xlabel("time [s]")
    return made


def test_png_has_the_size_of_the_figure(tmp_path: Path) -> None:
    write_figure(tmp_path / "a.png", figure())
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (300, 200)


def test_svg_keeps_text_as_text(tmp_path: Path) -> None:
    write_figure(tmp_path / "a.svg", figure())
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert any("time [s]" in "".join(element.itertext()) for element in root.iter() if "text" in element.tag)


def test_pdf_embeds_outlines_instead_of_bitmaps(tmp_path: Path) -> None:
    write_figure(tmp_path / "folder" / "a.PDF", figure())
    content = (tmp_path / "folder" / "a.PDF").read_bytes()
    assert content.startswith(b"%PDF")
    assert b"/Type3" not in content


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_equal_figures_give_equal_files(suffix: str) -> None:
    assert figure_content(figure(), suffix) == figure_content(figure(), suffix)


@pytest.mark.parametrize("name", ["a.jpg", "a", "a.svg.gz"])
def test_other_suffix_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidValueError, match=r"a name that ends in \.png, \.svg, \.pdf"):
        write_figure(tmp_path / name, figure())
    assert not list(tmp_path.iterdir())


def test_notebook_shows_the_figure() -> None:
    assert Image.open(io.BytesIO(figure()._repr_png_())).format == "PNG"
