"""Spectrum files: every format read back from text made here, and every way in which a file can be broken."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError, SpectrumFileError
from spectral_core.spectra import Spectrum
from spectral_core.spectrum_files import read_optical_constants, read_spectra, read_spectrum, write_spectrum


def file(tmp_path, text, name="lamp.csv"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return path


def samples(spectrum):
    return spectrum.wavelengths_nm.tolist(), spectrum.values.tolist()


# --- columns --------------------------------------------------------------------------------------------------------

PLAIN = ([400.0, 410.0, 425.5], [0.1, 0.25, 0.5])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "400,0.1\n410,0.25\n425.5,0.5\n"),
        ("a.csv", "wavelength,value\n400,0.1\n410,0.25\n425.5,0.5"),
        ("a.csv", "# made here\r\n\r\n400, 0.1 \r\n410 ,0.25\r\n425.5,0.5\r\n\r\n"),
        ("a.csv", "\ufeffwavelength (nm),reflectance\n400,0.1,\n410,0.25,\n425.5,0.5,\n"),
        ("a.csv", "400;0,1\n410;0,25\n425,5;0,5\n"),
        ("a.csv", '"nm","R"\n"400","0.1"\n"410","0.25"\n"425.5","0.5"\n'),
        ("a.tsv", "nm\tvalue\n400\t0.1\n410\t0.25\n425.5\t0.5\n"),
        ("a.tsv", "400\t0,1\n410\t0,25\n425,5\t0,5\n"),
        ("a.txt", "// scan\n! of a lamp\n  400   1e-1\n  410   2.5E-1\n  425.5 +.5\n"),
        ("a.txt", "400 0,1\n410 0,25\n425,5 0,5\n"),
        ("a.spd", "400 0.1\n410 0.25\n425.5 0.5\n"),
        ("a.spd", "# lamp\n400\t0.1\n410\t0.25\n425.5\t0.5\n"),
        ("a.csv", "wavelength (um),R (%)\n0.400,10\n0.410,25\n0.4255,50\n"),
        ("a.csv", "wavelength_um,R\n0.400,0.1\n0.410,0.25\n0.4255,0.5\n"),
        ("a.csv", "nm,percent reflectance\n400,10\n410,25\n425.5,50\n"),
        ("a.csv", "nm,R\n425.5,0.5\n410,0.25\n400,0.1\n"),
        ("a.csv", "angstrom,R\n4000,0.1\n4100,0.25\n4255,0.5\n"),
        ("a.csv", "λ nm,R\n400,0.1\n410,0.25\n425.5,0.5\n".encode()),
        ("a.csv", "# r\xe9flectance\n400,0.1\n410,0.25\n425.5,0.5\n".encode("latin-1")),
    ],
)
def test_columns_are_read(tmp_path, name, text):
    assert samples(read_spectrum(file(tmp_path, text, name))) == PLAIN


def test_options_override_the_header(tmp_path):
    path = file(tmp_path, "x,y\n0.4,10\n0.41,25\n0.4255,50\n")
    assert samples(read_spectrum(path, unit="percent", wavelength_unit="um")) == PLAIN
    path = file(tmp_path, "nm,R %\n400,0.1\n410,0.25\n425.5,0.5\n")
    assert samples(read_spectrum(path, unit="fraction")) == PLAIN
    assert read_spectrum(path, interpolation="lagrange").interpolation == "lagrange"
    with pytest.raises(InvalidParameterError, match="unit must be one of auto"):
        read_spectrum(path, unit="permille")
    with pytest.raises(InvalidParameterError, match="negative must be one of"):
        read_spectrum(path, negative="drop")
    with pytest.raises(SpectrumFileError, match="wavelength unit must be nm"):
        read_spectrum(path, wavelength_unit="inch")


def test_several_columns(tmp_path):
    path = file(tmp_path, "nm,paper,ink (%),lamp\n400,0.8,20,55\n500,0.9,30,66\n")
    paper, ink, lamp = read_spectra(path)
    assert [s.name for s in (paper, ink, lamp)] == ["paper", "ink", "lamp"]
    assert ink.values.tolist() == [0.2, 0.3]  # percent in this column only
    assert lamp.values.tolist() == [55.0, 66.0]
    assert read_spectrum(path, "ink") == ink
    assert read_spectrum(path, 2) == lamp
    with pytest.raises(SpectrumFileError, match="no column 'brass'; its columns are paper, ink, lamp"):
        read_spectrum(path, "brass")
    with pytest.raises(SpectrumFileError, match="has 3 value columns, but number 3"):
        read_spectrum(path, 3)


def test_names(tmp_path):
    assert read_spectrum(file(tmp_path, "400,1\n500,2\n", "blue lamp.csv")).name == "blue lamp"
    assert read_spectrum(file(tmp_path, "nm,value\n400,1\n500,2\n", "x.csv")).name == "x"
    assert read_spectrum(file(tmp_path, "nm,cadmium\n400,1\n500,2\n", "x.csv")).name == "cadmium"
    assert read_spectrum(file(tmp_path, "# name: my lamp\n400,1\n500,2\n", "x.spd")).name == "my lamp"


def test_a_single_line_is_a_constant(tmp_path):
    assert read_spectrum(file(tmp_path, "560,0.5\n")) == Spectrum.constant(0.5)


def test_negative_values(tmp_path):
    path = file(tmp_path, "nm,R\n380,0.1\n390,-0.003\n400,0.2\n")
    with pytest.raises(
        SpectrumFileError, match=r"lamp.csv line 3: values must not be negative, but at 390 nm one is -0"
    ):
        read_spectrum(path)
    assert read_spectrum(path, negative="zero").values.tolist() == [0.1, 0.0, 0.2]
    kept = read_spectrum(path, negative="keep")
    assert kept.signed
    assert kept.values.tolist() == [0.1, -0.003, 0.2]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("400,1\n505,1\n500,1\n",
         "wavelengths must increase strictly: 500.0 nm follows 505.0 nm in lamp.csv line 3"),
        ("400,1\n500,1\n500,2\n", "wavelengths must increase strictly: 500.0 nm follows 500.0 nm in lamp.csv line 3"),
        ("500,1\n400,1\n350,1\n375,1\n", "must decrease strictly, as they mostly do: 375.0 nm follows 350.0 nm"),
        ("nm,R\n400,1\n410,abc\n", "lamp.csv line 3: the value 'abc' is not a number"),
        ("nm,R\n400,1\n,2\n", "lamp.csv line 3: the wavelength is missing"),
        ("nm,R,Q\n400,1,2\n410,,2\n", "lamp.csv line 3: the value is missing"),
        ("nm,R\n400,1\n410,nan\n", "lamp.csv line 3: the value must be finite, but is nan"),
        ("nm,R\n400,1\n410,1e999\n", "lamp.csv line 3: the value must be finite, but is 1e999"),
        ("400,1\n410,2,3\n", "lamp.csv line 2: has 3 columns, but line 1 has 2"),
        ("400,1\n410\n", "lamp.csv line 2: has 1 column, but line 1 has 2; a value is missing: give it"),
        ("nm,R\n400,1\n410,\n", "lamp.csv line 3: has 1 column, but line 2 has 2; a value is missing"),
        ("Name,400 nm,410 nm\nBlue,1,2\n", "each line must hold a wavelength and what was measured there"),
        ("# nothing\nnm,R\n", "lamp.csv: holds no line with a wavelength and a value"),
        ("", "lamp.csv: holds no line with a wavelength and a value"),
        ("0,1\n400,2\n", "lamp.csv line 1: wavelengths must be positive, but this is 0.0 nm"),
        ("-400,1\n400,2\n", "line 1: wavelengths must be positive"),
        ("0.4,1\n0.7,2\n", "line 2: the longest wavelength is 0.7 nm; if it is meant in micrometres"),
        ("400,1\n\0\0,2\n", "lamp.csv: is not a text file"),
    ],
)  # fmt: skip
def test_broken_columns_are_refused_with_their_line(tmp_path, text, reason):
    with pytest.raises(SpectrumFileError) as caught:
        read_spectrum(file(tmp_path, text))
    assert reason in str(caught.value)


def test_missing_files_folders_and_suffixes(tmp_path):
    with pytest.raises(SpectrumFileError, match=r"gone.csv cannot be read: No such file"):
        read_spectrum(tmp_path / "gone.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(SpectrumFileError, match=r"folder.csv cannot be read"):
        read_spectrum(tmp_path / "folder.csv")
    with pytest.raises(SpectrumFileError, match=r"lamp.xlsx: the suffix '.xlsx' is none of .csv"):
        read_spectrum(file(tmp_path, "400,1\n", "lamp.xlsx"))
    with pytest.raises(SpectrumFileError, match="holds optical constants"):
        read_spectrum(file(tmp_path, "DATA:\n", "Cu.yml"))


@settings(max_examples=300)
@given(st.binary(max_size=200), st.sampled_from([".csv", ".spd", ".jdx", ".spdx", ".yml", ".txt"]))
def test_any_bytes_are_read_or_refused_by_name(tmp_path_factory, content, suffix):
    path = tmp_path_factory.getbasetemp() / f"noise{suffix}"
    path.write_bytes(content)
    reader = read_optical_constants if suffix == ".yml" else read_spectrum
    message = ""
    try:
        reader(path)
    except SpectrumFileError as error:
        message = str(error)
    assert "noise" in message or not message


# --- writing --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".csv", ".tsv", ".spd"])
@given(
    values=st.lists(st.floats(0.0, 1e100), min_size=1, max_size=6),
    interpolation=st.sampled_from(["linear", "lagrange"]),
)
def test_writing_and_reading_gives_the_same_spectrum(tmp_path_factory, suffix, values, interpolation):
    path = tmp_path_factory.getbasetemp() / f"round{suffix}"
    wavelengths = 380.1 + np.pi * np.arange(len(values))
    spectrum = Spectrum(wavelengths, values, "a name", interpolation)
    write_spectrum(path, spectrum, "first\nsecond")
    read = read_spectrum(path)
    assert read == spectrum
    assert (read.name, read.interpolation) == ("a name", interpolation)
    np.testing.assert_array_equal(read.wavelengths_nm, spectrum.wavelengths_nm)
    assert path.read_text(encoding="utf-8").startswith("# first\n# second\n# name: a name\n")


def test_writing_replaces_whole_files_or_nothing(tmp_path, monkeypatch):
    path = tmp_path / "lamp.csv"
    write_spectrum(path, Spectrum.constant(0.5))
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", full)
        with pytest.raises(SpectrumFileError, match=r"lamp.csv cannot be written: .*No space left"):
            write_spectrum(path, Spectrum.constant(0.7))
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["lamp.csv"]
    with pytest.raises(SpectrumFileError, match="cannot be written"):
        write_spectrum(tmp_path / "no folder" / "lamp.csv", Spectrum.constant(0.7))
    with pytest.raises(SpectrumFileError, match=r"suffix must be .csv, .tsv or .spd"):
        write_spectrum(tmp_path / "lamp.jdx", Spectrum.constant(0.7))


# --- JCAMP-DX -------------------------------------------------------------------------------------------------------

HEAD = """##TITLE= Blue paint $$ made here
##JCAMP-DX= 4.24
##DATA TYPE= REFLECTANCE SPECTRUM
##XUNITS= {xunits}
##YUNITS= {yunits}
##XFACTOR= 1.0
##YFACTOR= {yfactor}
##FIRSTX= {first}
##LASTX= {last}
##NPOINTS= {points}
##XYDATA= (X++(Y..Y))
"""


def jcamp(data, xunits="NANOMETERS", yunits="REFLECTANCE", yfactor="0.01", first=400, last=450, points=6):
    head = HEAD.format(xunits=xunits, yunits=yunits, yfactor=yfactor, first=first, last=last, points=points)
    return head + data + "\n##END=\n"


PAIRS = "##TITLE=t\n##XUNITS=MICROMETERS\n##YUNITS=TRANSMITTANCE\n##XYPOINTS=(XY..XY)\n"

# The same six ordinates 100, 101, 102, 104, 104, 99 in every form of the standard's section 5.
FORMS = {
    "plain": "400 100 101 102\n430 104 104 99",
    "packed": "400+100+101+102\n430+104+104+99",
    "squeezed": "400A00A01A02\n430A04A04I9",
    "differences": "400A00JJK%n",
    "differences over two lines": "400A00JJ\n420A02K%n",
    "repeated": "400A00A01A02A04TI9",
    "repeated differences": "400A00JTK%n",
}


@pytest.mark.parametrize("form", list(FORMS))
def test_jcamp_forms_of_numbers(tmp_path, form):
    spectrum = read_spectrum(file(tmp_path, jcamp(FORMS[form]), "paint.jdx"))
    assert spectrum.name == "Blue paint"
    assert spectrum.wavelengths_nm.tolist() == [400.0, 410.0, 420.0, 430.0, 440.0, 450.0]
    np.testing.assert_allclose(spectrum.values, [1.00, 1.01, 1.02, 1.04, 1.04, 0.99], rtol=1e-15)


def test_jcamp_long_repetitions(tmp_path):
    slope = read_spectrum(file(tmp_path, jcamp("400A00JV%", yfactor="1"), "a.jdx"))
    assert slope.values.tolist() == [100.0, 101.0, 102.0, 103.0, 104.0, 104.0]
    flat = read_spectrum(file(tmp_path, jcamp("400A00B00W", yfactor="1"), "b.jdx"))
    assert flat.values.tolist() == [100.0, 200.0, 200.0, 200.0, 200.0, 200.0]


def test_jcamp_wave_numbers_percent_and_pairs(tmp_path):
    text = jcamp("25000 50 60\n20000 70", "1/CM", "PERCENT REFLECTANCE", "1.0", 25000, 20000, 3)
    spectrum = read_spectrum(file(tmp_path, text, "a.dx"))
    np.testing.assert_allclose(spectrum.wavelengths_nm, [400.0, 1e7 / 22500.0, 500.0], rtol=1e-15)
    assert spectrum.values.tolist() == [0.5, 0.6, 0.7]
    spectrum = read_spectrum(file(tmp_path, PAIRS + "0.4,0.1; 0.5,0.2;\n0.6 0.3\n##END=\n", "b.jcamp"))
    np.testing.assert_allclose(spectrum.wavelengths_nm, [400.0, 500.0, 600.0], rtol=1e-15)
    assert spectrum.values.tolist() == [0.1, 0.2, 0.3]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (jcamp(FORMS["plain"]).replace("##TITLE= Blue paint", "##OWNER= me"), "must begin with ##TITLE="),
        (jcamp(FORMS["plain"]).replace("##XUNITS= NANOMETERS\n", ""), "##XUNITS= is missing"),
        (jcamp(FORMS["plain"]).replace("##FIRSTX= 400\n", ""), "##FIRSTX= is missing"),
        (jcamp(FORMS["plain"], xunits="SECONDS"), "paint.jdx line 4: XUNITS must be nanometers"),
        (jcamp(FORMS["plain"], yunits="ABSORBANCE"), "line 5: values in ABSORBANCE are not linear in light"),
        (jcamp(FORMS["plain"], points=7, last=460), "line 10: announces 7 points, but the data hold 6"),
        (jcamp("400 100 101 102\n470 104 104 99"), "line 13: the abscissa check 470 differs from 430"),
        (jcamp("400A00JJ\n420A05K%n"), "line 13: the ordinate check 105 differs from 102"),
        (jcamp("400 100 ! 102\n430 104 104 99"), "line 12: '! 102' is not a number"),
        (jcamp("400 100 ? 102\n430 104 104 99"), "line 12: has an invalid point"),
        (jcamp("400 T100 101 102 104 99"), "line 12: the repetition 'T100' follows no value"),
        (jcamp("400 J 101 102 104 99 1"), "line 12: the difference 'J' follows no value"),
        (jcamp(FORMS["plain"]).replace("(X++(Y..Y))", "(R++(I..I))"), "the form of the data must be"),
        (jcamp(FORMS["plain"]).split("##XYDATA")[0], "holds no ##XYDATA= or ##XYPOINTS="),
        (jcamp(FORMS["plain"]).replace("##DATA TYPE=", "##NTUPLES="), "NTUPLES data are not supported"),
        (jcamp(FORMS["plain"]).replace("##NPOINTS= 6", "##NPOINTS= six"), "line 10: the label NPOINTS 'six' is not a"),
        (jcamp(FORMS["plain"]).replace("##NPOINTS= 6", "##NPOINTS= 0"), "must announce at least one point"),
        (PAIRS + "0.4,0.1; 0.5\n", "line 5: must hold pairs x, y, but holds 3 numbers"),
        (PAIRS + "0.4,blue\n", "line 5: the ordinate 'blue' is not a number"),
        (jcamp("0 50 60\n20000 70", "1/CM", first=0, last=40000, points=3), "wave numbers must be positive"),
        (jcamp(FORMS["plain"]).replace("##XFACTOR=", "##XFACTOR"), "has no equals sign"),
    ],
)
def test_broken_jcamp_is_refused_with_its_line(tmp_path, text, reason):
    with pytest.raises(SpectrumFileError, match=r"paint.jdx") as caught:
        read_spectrum(file(tmp_path, text, "paint.jdx"))
    assert reason in str(caught.value)


# --- SPDX -----------------------------------------------------------------------------------------------------------

SPDX = """<?xml version="1.0" encoding="UTF-8"?>
<IESTM2714 xmlns="iestm2714" version="1.0">
  <Header><Manufacturer>none</Manufacturer><Description>Test lamp</Description></Header>
  <SpectralDistribution>
    <SpectralQuantity>flux</SpectralQuantity>
    <SpectralData wavelength="400">0.034</SpectralData>
    <SpectralData wavelength="403.1"> 0.037 </SpectralData>
    <SpectralData wavelength="405.5">0.069</SpectralData>
  </SpectralDistribution>
</IESTM2714>
"""


@pytest.mark.parametrize("text", [SPDX, SPDX.replace("<", "<ies:").replace("<ies:/", "</ies:").replace("<ies:?", "<?")
                                  .replace('xmlns="', 'xmlns:ies="')])  # fmt: skip
def test_spdx(tmp_path, text):
    spectrum = read_spectrum(file(tmp_path, text, "lamp.spdx"))
    assert spectrum.name == "Test lamp"
    assert samples(spectrum) == ([400.0, 403.1, 405.5], [0.034, 0.037, 0.069])
    percent = read_spectrum(file(tmp_path, text, "lamp.xml"), unit="percent")
    np.testing.assert_allclose(percent.values, [0.00034, 0.00037, 0.00069], rtol=1e-15)


def test_spdx_equals_colour_science(colour, tmp_path):
    path = file(tmp_path, SPDX, "lamp.spdx")
    expected = colour.SpectralDistribution_IESTM2714(str(path)).read()
    got = read_spectrum(path)
    np.testing.assert_array_equal(got.wavelengths_nm, expected.wavelengths)
    np.testing.assert_array_equal(got.values, expected.values)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (SPDX.replace("0.034", "bright"), "lamp.spdx line 6: the value 'bright' is not a number"),
        (SPDX.replace('wavelength="400"', ""), "line 6: the attribute wavelength is missing"),
        (SPDX.replace('"403.1"', '"399"'), "399.0 nm follows 400.0 nm in lamp.spdx line 7"),
        (SPDX.replace("</Header>", ""), "mismatched tag"),
        (SPDX.replace("SpectralData ", "Data ").replace("SpectralData>", "Data>"), "holds no SpectralData"),
        (SPDX.replace("<IES", '<!DOCTYPE x [<!ENTITY a "b">]>\n<IES', 1), "document type declarations are not allowed"),
        ("", "no element found"),
    ],
)
def test_broken_spdx_is_refused_with_its_line(tmp_path, text, reason):
    with pytest.raises(SpectrumFileError, match=r"lamp.spdx") as caught:
        read_spectrum(file(tmp_path, text, "lamp.spdx"))
    assert reason in str(caught.value)


# --- optical constants ----------------------------------------------------------------------------------------------

YAML = """# this file is part of refractiveindex.info database

REFERENCES: |
    A. Author. <i>Journal</i>
    <b>1</b>, 2 (2003)
COMMENTS: "Evaporated film"
DATA:
  - type: tabulated nk
    data: |
        0.57 0.5 2.1
        0.58 0.6 2.2
        0.59 0.7 2.3
CONDITIONS:
  temperature: 293
"""
YAML_TWO = """DATA:
  - type: tabulated n
    data: |
        0.50 1.5
        0.60 1.4
  - type: tabulated k
    data: |
        0.45 0.0
        0.65 0.2
"""


def test_yaml_of_the_database(tmp_path):
    constants = read_optical_constants(file(tmp_path, YAML, "Cu.yml"))
    assert constants.wavelengths_nm.tolist() == [570.0, 580.0, 590.0]  # exactly, though 0.57 * 1000 is not
    assert constants.n.tolist() == [0.5, 0.6, 0.7]
    assert constants.k.tolist() == [2.1, 2.2, 2.3]
    assert constants.name == "Cu"
    assert constants.source == "A. Author. <i>Journal</i> <b>1</b>, 2 (2003)"
    assert constants.comment.strip('"') == "Evaporated film"
    assert read_optical_constants(file(tmp_path, YAML, "Cu.yml"), "copper").name == "copper"


def test_yaml_with_n_and_k_apart(tmp_path):
    constants = read_optical_constants(file(tmp_path, YAML_TWO, "glass.yaml"))
    assert constants.wavelengths_nm.tolist() == [500.0, 600.0]
    np.testing.assert_allclose(constants.k, [0.05, 0.15], rtol=1e-14)
    only_n = read_optical_constants(file(tmp_path, YAML_TWO.split("  - type: tabulated k")[0], "glass.yml"))
    assert only_n.k.tolist() == [0.0, 0.0]


def test_repeated_wavelengths_of_the_database_are_averaged(tmp_path):
    text = YAML.replace("0.59 0.7 2.3", "0.58 0.8 2.4\n        0.59 0.7 2.3")
    constants = read_optical_constants(file(tmp_path, text, "Cu.yml"))
    np.testing.assert_allclose(constants.n, [0.5, 0.7, 0.7], rtol=1e-15)
    np.testing.assert_allclose(constants.k, [2.1, 2.3, 2.3], rtol=1e-15)


def test_optical_constants_in_columns(tmp_path):
    text = "# source: somebody\nwavelength (um),n,k\n0.5,1.1,2\n0.6,1.2,3\n"
    constants = read_optical_constants(file(tmp_path, text, "metal.csv"))
    assert constants.wavelengths_nm.tolist() == [500.0, 600.0]
    assert (constants.n.tolist(), constants.k.tolist()) == ([1.1, 1.2], [2.0, 3.0])
    assert constants.source == "somebody"
    with pytest.raises(SpectrumFileError, match="must have the columns wavelength, n, k, but has 2"):
        read_optical_constants(file(tmp_path, "500,1\n600,2\n", "metal.csv"))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (YAML.replace("0.6 2.2", "0.6"), "Cu.yml line 11: has 2 numbers, but the table has 3 columns"),
        (YAML.replace("0.6 2.2", "0.6 x"), "Cu.yml line 11: the k 'x' is not a number"),
        (YAML.replace("0.6 2.2", "-0.6 2.2"), "Cu.yml line 11: n must be positive, but is -0.6"),
        (YAML.replace("0.6 2.2", "0.6 -2.2"), "Cu.yml line 11: k must be 0 or more, but is -2.2"),
        (YAML.replace("0.58 0.6", "0.50 0.6"), "500.0 nm follows 570.0 nm in Cu.yml line 11"),
        (YAML.replace("tabulated nk", "formula 2"), "line 8: data of the type 'formula 2' are not read"),
        (YAML.replace("DATA:", "OTHER:"), "holds no tabulated n or k under DATA"),
        (YAML_TWO.replace("tabulated n", "tabulated k", 1), "tabulates k a second time"),
        ("DATA:\n" + YAML_TWO[YAML_TWO.index("  - type: tabulated k"):], "tabulates k but not n"),
        (YAML_TWO.replace("0.45 0.0\n        0.65", "1.45 0.0\n        1.65"), "over ranges that do not meet"),
        (YAML.split("        0.57")[0], "has an empty table of n and k"),
        ("DATA:\n  tabulated: nk\n", "line 2: DATA must hold a list of tables"),
    ],
)  # fmt: skip
def test_broken_yaml_is_refused_with_its_line(tmp_path, text, reason):
    with pytest.raises(SpectrumFileError, match=r"Cu.yml") as caught:
        read_optical_constants(file(tmp_path, text, "Cu.yml"))
    assert reason in str(caught.value)


# --- damage ---------------------------------------------------------------------------------------------------------

SOUND = {
    ".csv": "# name: lamp\nwavelength_nm,value\n400,0.1\n410,0.25\n425.5,0.5\n",
    ".tsv": "nm\tR (%)\n400\t0,1\n410\t0,25\n425,5\t0,5\n",
    ".jdx": jcamp(FORMS["repeated differences"]),
    ".dx": jcamp(FORMS["differences over two lines"]),
    ".spdx": SPDX,
    ".yml": YAML,
}
BITS = st.one_of(
    st.text(max_size=4),
    st.sampled_from(["nan", "inf", "-", "1e400", "1e-400", "1e999999999999", "S99999999999", "9" * 5000, "\0", "\n"]),
)  # fmt: skip


@settings(max_examples=600)
@given(st.sampled_from(list(SOUND)), st.floats(0.0, 1.0), st.integers(0, 12), BITS)
def test_damaged_files_are_read_or_refused_by_name(tmp_path_factory, suffix, place, length, bit):
    text = SOUND[suffix]
    start = int(place * len(text))
    path = tmp_path_factory.getbasetemp() / f"damaged{suffix}"
    path.write_bytes((text[:start] + bit + text[start + length :]).encode("utf-8", "surrogatepass"))
    message = ""
    try:
        if suffix == ".yml":
            read_optical_constants(path)
        else:
            assert all(np.isfinite(spectrum.values).all() for spectrum in read_spectra(path))
    except SpectrumFileError as error:
        message = str(error)
    assert "damaged" in message or not message


def test_numbers_beyond_all_bounds(tmp_path):
    for text, reason in (
        (jcamp("400A00Z99999999999"), "makes more points than the file announces"),
        (jcamp("400 1E+400 101 102 104 104 99"), "the ordinate must be finite"),
        (jcamp(FORMS["plain"], yfactor="1e307"), "the value is too large"),
        (jcamp("1E-310 50 60", "1/CM", first="1e-310", last="2e-310", points=2), "wavelengths must be positive"),
    ):
        with pytest.raises(SpectrumFileError, match=r"big\.jdx line \d+: ") as caught:
            read_spectrum(file(tmp_path, text, "big.jdx"))
        assert reason in str(caught.value)
