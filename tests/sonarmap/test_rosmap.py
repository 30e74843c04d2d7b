"""Maps of ROS map_server: every image, mode, threshold and place, against a plain twin."""

import math

import numpy as np
import pytest
from PIL import Image
from support import cells

import sonarmap as sm
from sonarmap.mapfile import read_map_and_notes
from sonarmap.rosmap import read_ros_map

YAML = {
    "image": "map.pgm",
    "resolution": "0.5",
    "origin": "[-1.0, 2.0, 0.0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}
# Greys of an image of 2 x 3 pixels, top row first, as shares of white.
SHARES = np.array([[0.0, 0.2, 0.4], [0.6, 0.8, 1.0]])


def write_yaml(folder, **changes):
    """Write a map.yaml of some keys; None leaves one out."""
    keys = {key: value for key, value in (YAML | changes).items() if value is not None}
    path = folder / "map.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items()), encoding="utf-8")
    return path


def write_pgm(path, values, white=255):
    values = np.asarray(values)
    rows, cols = values.shape
    kind = "u1" if white < 256 else ">u2"
    path.write_bytes(f"P5\n{cols} {rows}\n{white}\n".encode() + values.astype(kind).tobytes())


# --- images --------------------------------------------------------------------------------------


def pgm(white):
    def write(path, shares):
        write_pgm(path, np.rint(shares * white), white)

    return write


def ascii_pgm(path, shares):
    rows = ["  ".join(str(round(255 * share)) for share in row) for row in shares]
    body = " # not a grey: 7\n\t".join(rows)
    path.write_bytes(
        f"P2 # made by hand\r\n# another comment\n{shares.shape[1]}\t{shares.shape[0]}\n"
        f"#255\n255\n{body}\n".encode()
    )


def commented_pgm(path, shares):
    rows, cols = shares.shape
    greys = np.rint(shares * 255).astype("u1").tobytes()
    head = f"P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n{cols} # wide\n{rows}\n255\n"
    path.write_bytes(head.encode() + greys)


def picture(mode, dtype="u1", white=255):
    def write(path, shares):
        values = np.rint(shares * white).astype(dtype)
        if mode == "RGB":  # of the same mean, in no channel grey
            values = np.stack([values, np.maximum(values, 30) - 30, values], axis=-1)
            values[..., 2] = 3 * np.rint(shares * 255) - values[..., 0].astype(int) - values[..., 1]
        Image.fromarray(values).save(path)

    return write


def palette(path, shares):
    Image.fromarray(np.rint(shares * 255).astype("u1")).convert("P").save(path)


IMAGES = {
    "pgm": pgm(255),
    "coarse pgm": pgm(5),
    "pgm of 100": pgm(100),
    "16 bit pgm": pgm(65535),
    "12 bit pgm": pgm(4095),
    "ascii pgm": ascii_pgm,
    "pgm with comments": commented_pgm,
    "png": picture("L"),
    "16 bit png": picture("I;16", "u2", 65535),
    "palette png": palette,
    "bmp": picture("L"),
}


def published(share, mode, *, negate=False, occupied=0.65, free=0.196):
    """Return what map_server publishes for a pixel, -1 to 100, not rounded."""
    if mode == "raw":
        return round(255 * share) if round(255 * share) <= 100 else -1
    occ = (share * 255 if negate else 255 - share * 255) / 255
    if occ > occupied:
        return 100
    if occ < free:
        return 0
    return -1 if mode == "trinary" else 100 * (occ - free) / (occupied - free)


def expected(shares, mode, **keys):
    """Return (P, observed) of the cells of an image, its rows from the bottom up."""
    values = np.vectorize(lambda share: published(share, mode, **keys), otypes=[float])(shares)
    p = np.where(values < 0, 0.5, values / 100)
    if mode == "trinary":
        p = p.clip(0.01, 0.99)
    return p[::-1], (values >= 0)[::-1]


@pytest.mark.parametrize("kind", IMAGES)
@pytest.mark.parametrize("mode", ["trinary", "scale", "raw", None])
@pytest.mark.parametrize("negate", ["0", "1", "false", "true"])
def test_every_image_in_every_mode(kind, mode, negate, tmp_path):
    name = f"image.{kind.rsplit(maxsplit=1)[-1] if kind[-3:] in ('png', 'bmp') else 'pgm'}"
    IMAGES[kind](tmp_path / name, SHARES)
    m = sm.read_map(write_yaml(tmp_path, image=name, mode=mode, negate=negate))
    negated = negate in ("1", "true")
    p, observed = expected(SHARES, mode or "trinary", negate=negated)
    assert m.grid == sm.GridSpec(0.5, (-1.0, 2.0), (2, 3))
    np.testing.assert_allclose(m.probability, p, atol=1e-12)
    np.testing.assert_array_equal(m.observed, observed)
    assert (m.occupied_from, m.free_up_to) == (0.65, 0.196)


def test_colours_are_averaged(tmp_path):
    picture("RGB")(tmp_path / "map.png", np.array([[0.3, 0.5, 0.8]]))
    with Image.open(tmp_path / "map.png") as image:
        mean = np.asarray(image).mean(axis=2) / 255
    assert mean.round(2).tolist() == [[0.3, 0.5, 0.8]]
    m = sm.read_map(write_yaml(tmp_path, image="map.png", mode="scale"))
    np.testing.assert_allclose(m.probability, expected(mean, "scale")[0])


# Grey, alpha, and what a cell is worth; None: unknown.
CLEAR = [
    # map_server averages alpha with the colours: an opaque black is dark by three quarters.
    ("trinary", 0, 255, 0.99),
    ("trinary", 255, 255, 0.01),
    ("trinary", 0, 0, 0.99),
    ("trinary", 255, 0, None),
    ("trinary", 140, 255, None),
    # Whatever can be seen through is unknown.
    ("scale", 0, 255, 1.0),
    ("scale", 255, 255, 0.0),
    ("scale", 0, 254, None),
    ("scale", 255, 0, None),
    ("scale", 128, 255, (127 / 255 - 0.196) / (0.65 - 0.196)),
    ("raw", 60, 255, 0.6),
    ("raw", 60, 0, 0.6),
]


@pytest.mark.parametrize("kind", ["LA", "RGBA"])
@pytest.mark.parametrize(("mode", "grey", "alpha", "p"), CLEAR)
def test_what_can_be_seen_through(kind, mode, grey, alpha, p, tmp_path):
    channels = [grey] * (len(kind) - 1) + [alpha]
    Image.fromarray(np.array([[channels]], np.uint8)).save(tmp_path / "map.png")
    m = sm.read_map(write_yaml(tmp_path, image="map.png", mode=mode))
    assert m.observed.tolist() == [[p is not None]]
    assert m.probability[0, 0] == pytest.approx(0.5 if p is None else p)


@pytest.mark.parametrize("white", [255, 65535])
def test_raw_is_a_per_cent_of_255(white, tmp_path):
    values = np.array([[0, 1, 50], [100, 101, 255]])
    write_pgm(tmp_path / "map.pgm", values * (white // 255), white)
    m = sm.read_map(write_yaml(tmp_path, mode="raw"))
    np.testing.assert_allclose(m.probability, [[1.0, 0.5, 0.5], [0.0, 0.01, 0.5]])
    assert m.observed.tolist() == [[True, False, False], [True, True, True]]


# --- thresholds ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("occupied", "free"),
    [(0.65, 0.25), (0.4, 0.3), (0.9, 0.0), (1.0, 0.5), (0.995, 0.2), (0.3, 0.001), (0.005, 0.002)],
)
@pytest.mark.parametrize("mode", ["trinary", "scale"])
def test_any_thresholds(occupied, free, mode, tmp_path):
    shares = np.arange(256).reshape(16, 16) / 255
    write_pgm(tmp_path / "map.pgm", np.arange(256).reshape(16, 16))
    m = sm.read_map(write_yaml(tmp_path, mode=mode, occupied_thresh=occupied, free_thresh=free))
    p, observed = expected(shares, mode, occupied=occupied, free=free)
    np.testing.assert_allclose(m.probability, p, atol=1e-9)
    np.testing.assert_array_equal(m.observed, observed)
    if mode == "trinary":
        # Whatever the thresholds are, they do not undo the three states.
        np.testing.assert_array_equal(m.occupied, p == 0.99)
        np.testing.assert_array_equal(m.free, p == 0.01)
    else:
        assert (m.occupied_from, m.free_up_to) == (occupied, free)


def test_a_grey_on_a_threshold_is_not_beyond_it(tmp_path):
    # (255 - 102) / 255 = 0.6 and (255 - 204) / 255 = 0.2, exactly.
    write_pgm(tmp_path / "map.pgm", [[101, 102, 103, 203, 204, 205]])
    m = sm.read_map(write_yaml(tmp_path, occupied_thresh=0.6, free_thresh=0.2))
    assert m.probability.tolist() == [[0.99, 0.5, 0.5, 0.5, 0.5, 0.01]]


# --- numbers and paths of the YAML ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "number"),
    [("1e-05", 1e-5), ("1E-5", 1e-5), ("5.e-2", 0.05), (".05", 0.05), ("+0.05", 0.05),
     ("'0.05'", 0.05), ("010", 10.0), ("1", 1.0)],
)  # fmt: skip
def test_numbers_are_read_as_map_server_reads_them(text, number, tmp_path):
    write_pgm(tmp_path / "map.pgm", [[0]])
    m = sm.read_map(write_yaml(tmp_path, resolution=text, origin=f"[{text}, -1e-05, 0]"))
    assert m.grid == sm.GridSpec(number, (number, -1e-5), (1, 1))


@pytest.mark.parametrize("negate", ["1", "true", "True", "yes", "on"])
def test_negate_has_many_words(negate, tmp_path):
    write_pgm(tmp_path / "map.pgm", [[0, 255]])
    assert sm.read_map(write_yaml(tmp_path, negate=negate)).probability.tolist() == [[0.01, 0.99]]


def test_the_image_may_lie_elsewhere(tmp_path, monkeypatch):
    images, maps = tmp_path / "images", tmp_path / "maps"
    images.mkdir()
    maps.mkdir()
    write_pgm(images / "a map.pgm", [[0]])
    monkeypatch.chdir(tmp_path)
    for image in ("../images/a map.pgm", images / "a map.pgm", '"../images/a map.pgm"'):
        path = write_yaml(maps, image=image)
        for given in (path, str(path), path.relative_to(tmp_path), maps):
            assert sm.read_map(given).occupied.tolist() == [[True]]


def test_keys_that_others_added_are_left_alone(tmp_path):
    write_pgm(tmp_path / "map.pgm", [[0]])
    path = write_yaml(tmp_path, frame="map", layers="{height: [1, 2]}")
    assert sm.read_map(path.rename(tmp_path / "map.yml")).occupied.all()


# --- maps that are turned ------------------------------------------------------------------------

# Of an image: the top row first. Its lower-left corner is the origin.
DRAWN = """
    #..
    .#?
"""
QUARTERS = {
    # degrees: drawing, lower-left corner in cells from the origin
    0: (DRAWN, (0, 0)),
    90: (".? \n .# \n #.", (-2, 0)),
    180: ("?#. \n ..#", (-3, -2)),
    -90: (".# \n #. \n ?.", (0, -3)),
    270: (".# \n #. \n ?.", (0, -3)),
    720: (DRAWN, (0, 0)),
}
GREY = {"#": 0, ".": 254, "?": 205}
P = {"#": 0.99, ".": 0.01, "?": 0.5}


def numbers(drawing, values):
    return np.vectorize(values.get, otypes=[float])(cells(drawing))


@pytest.mark.parametrize("degrees", QUARTERS)
def test_quarter_turns_lose_nothing(degrees, tmp_path):
    drawing, (col, row) = QUARTERS[degrees]
    write_pgm(tmp_path / "map.pgm", numbers(DRAWN, GREY)[::-1])
    origin = [1.25, -3.5, math.radians(degrees)]
    m, notes = read_map_and_notes(write_yaml(tmp_path, resolution="0.1", origin=origin))
    np.testing.assert_array_equal(m.probability, numbers(drawing, P))
    np.testing.assert_array_equal(m.observed, m.probability != 0.5)
    assert m.grid.resolution_m == 0.1
    assert m.grid.origin_xy_m == pytest.approx((1.25 + 0.1 * col, -3.5 + 0.1 * row))
    assert bool(notes) == (degrees not in (0, 720))


@pytest.mark.parametrize("degrees", [30, -17, 45, 122, 200.5])
def test_a_turned_map_takes_the_cell_that_a_centre_lies_in(degrees, rng, tmp_path):
    greys = rng.choice([0, 205, 254], (13, 21))
    write_pgm(tmp_path / "map.pgm", greys)
    yaw = math.radians(degrees)
    m, (note,) = read_map_and_notes(write_yaml(tmp_path, origin=[-1.0, 2.0, yaw]))
    known = {0: 0.99, 205: 0.5, 254: 0.01}
    found = 0
    for row in range(m.grid.rows):
        for col in range(m.grid.cols):
            x, y = (float(v) for v in m.grid.centre_of(row, col))
            place = complex(x + 1, y - 2) * np.exp(-1j * yaw) / 0.5
            i, j = math.floor(place.imag), math.floor(place.real)
            inside = 0 <= i < 13 and 0 <= j < 21
            found += inside
            assert m.probability[row, col] == (known[greys[12 - i, j]] if inside else 0.5)
            assert m.observed[row, col] == (inside and greys[12 - i, j] != 205)
    # Nearly every cell finds its like, for the area is the same.
    assert found == pytest.approx(13 * 21, rel=0.05)
    assert f"is turned by {math.degrees(math.remainder(yaw, math.tau)):.6g} degrees" in note
    assert f"13 x 21 cells were resampled, to the nearest cell, to {m.grid.rows} x" in note


# --- round trips ---------------------------------------------------------------------------------


def some_map(rng, *, stated):
    grid = sm.GridSpec(0.1 + 0.2, (1 / 3, -1e-7), (17, 23))
    p = rng.random(grid.shape)
    if stated:
        return sm.OccupancyMap.from_probability(
            grid, p, rng.random(grid.shape) < 0.7, occupied_from=0.8, free_up_to=0.4
        )
    return sm.OccupancyMap(grid, np.log(p / (1 - p)))


@pytest.mark.parametrize("stated", [True, False])
def test_a_saved_map_comes_back_as_its_three_states(stated, rng, tmp_path):
    m = some_map(rng, stated=stated)
    m.save(tmp_path)
    back = sm.read_map(tmp_path / "map.yaml")
    assert back.grid == m.grid
    # A map of evidence is drawn with map_server's own limits.
    occupied = m.occupied if stated else m.probability > 0.65
    free = m.free if stated else m.probability < 0.196
    np.testing.assert_array_equal(back.occupied, occupied)
    np.testing.assert_array_equal(back.free, free)
    np.testing.assert_array_equal(back.observed, occupied | free)


def test_a_saved_map_is_read_exactly_from_its_folder_or_npz(rng, tmp_path):
    m = some_map(rng, stated=True)
    m.save(tmp_path)
    for path in (tmp_path, tmp_path / "map.npz", str(tmp_path)):
        assert sm.read_map(path).probability.tobytes() == m.probability.tobytes()


def test_a_folder_of_ros_needs_no_npz(rng, tmp_path):
    some_map(rng, stated=True).save(tmp_path)
    (tmp_path / "map.npz").unlink()
    assert sm.read_map(tmp_path).grid.shape == (17, 23)


# --- bad input -----------------------------------------------------------------------------------

NUMBER = "must be a finite number"
BAD_KEYS = [
    # missing keys
    *(({key: None}, f"{key}: this key is missing") for key in YAML),
    (
        {"free_thresh": None, "free_tresh": "0.2"},
        "free_thresh: this key is missing; is 'free_tresh' meant for it?",
    ),
    # numbers
    ({"resolution": "fine"}, f"resolution {NUMBER}, got 'fine'"),
    ({"resolution": ""}, f"resolution {NUMBER}, got ''"),
    ({"resolution": "[0.05]"}, f"resolution {NUMBER}, got ['0.05']"),
    ({"resolution": "true"}, f"resolution {NUMBER}, got 'true'"),
    ({"resolution": "0x10"}, f"resolution {NUMBER}, got '0x10'"),
    ({"resolution": "1_0"}, f"resolution {NUMBER}, got '1_0'"),
    ({"resolution": ".inf"}, f"resolution {NUMBER}, got '.inf'"),
    ({"resolution": "1e999"}, f"resolution {NUMBER}, got '1e999'"),
    ({"resolution": "nan"}, f"resolution {NUMBER}, got 'nan'"),
    ({"resolution": "0"}, "resolution must be > 0 and <= 100 m, got '0'"),
    ({"resolution": "-0.05"}, "resolution must be > 0 and <= 100 m, got '-0.05'"),
    ({"resolution": "1e9"}, "resolution must be > 0 and <= 100 m, got '1e9'"),
    # thresholds
    ({"occupied_thresh": "65"}, "occupied_thresh must be within [0, 1], got '65'"),
    ({"free_thresh": "-0.1"}, "free_thresh must be within [0, 1], got '-0.1'"),
    ({"free_thresh": "low"}, f"free_thresh {NUMBER}, got 'low'"),
    ({"free_thresh": "0.7"}, "free_thresh must be < occupied_thresh, got 0.7 and 0.65"),
    ({"free_thresh": "0.65"}, "free_thresh must be < occupied_thresh, got 0.65 and 0.65"),
    # origin
    ({"origin": "[0, 0]"}, "origin must be [x, y, yaw], finite numbers, got ['0', '0']"),
    ({"origin": "[0, 0, north]"}, "origin must be [x, y, yaw], finite numbers, got ['0', '0', 'n"),
    ({"origin": "[0, nan, 0]"}, "origin must be [x, y, yaw], finite numbers, got ['0', 'nan'"),
    ({"origin": "0"}, "origin must be [x, y, yaw], finite numbers, got '0'"),
    ({"origin": "{x: 0, y: 0}"}, "origin must be [x, y, yaw], finite numbers, got {"),
    ({"origin": "[1e300, 0, 1]"}, "origin must lie within 1e+08 m, got ['1e300', '0', '1']"),
    # words
    ({"negate": "2"}, "negate must be 0 or 1, false or true, got '2'"),
    ({"negate": "[]"}, "negate must be 0 or 1, false or true, got []"),
    ({"mode": "Trinary"}, "mode must be trinary, scale or raw, got 'Trinary'"),
    ({"mode": "[raw]"}, "mode must be trinary, scale or raw, got ['raw']"),
    # images
    ({"image": ""}, "image must be the path of an image, got ''"),
    ({"image": "[a, b]"}, "image must be the path of an image, got ['a', 'b']"),
    ({"image": "gone.pgm"}, "image: FOLDER/gone.pgm: no such file"),
    ({"image": "."}, "image: FOLDER: is not a file"),
    ({"image": "/dev/zero"}, "image: /dev/zero: is not a file"),
    ({"image": "map.yaml"}, "image: FOLDER/map.yaml: is not a readable image (Unidentified"),
]


def complaint(read, path, folder):
    """Return the one line in which a file is refused, without its own name."""
    with pytest.raises(sm.InputError) as error:
        read(path)
    message = str(error.value).replace(str(folder), "FOLDER")
    assert "\n" not in message
    assert message.startswith(f"FOLDER/{path.name}: ")
    return message.removeprefix(f"FOLDER/{path.name}: ")


@pytest.mark.parametrize(("changes", "message"), BAD_KEYS)
def test_bad_keys(changes, message, tmp_path):
    write_pgm(tmp_path / "map.pgm", [[0]])
    path = write_yaml(tmp_path, **changes)
    assert complaint(sm.read_map, path, tmp_path).startswith(message)


def deep(levels):
    return b"a: " + b"[" * levels + b"]" * levels


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "is not a map.yaml: it must have keys with values"),
        (b"- 1\n- 2\n", "is not a map.yaml: it must have keys with values"),
        (b"image: [1, 2\n", "is not YAML: expected ',' or ']'"),
        (b"a: b: c\n", "is not YAML: mapping values are not allowed here at line 1"),
        (b"{[1]: 2}", "is not YAML: found unhashable key at line 1"),
        (b"\x89PNG\xff", "is not a map.yaml: not UTF-8 text"),
        (b"a: \x00", "is not YAML: "),
        (deep(5000), "is not YAML: RecursionError"),
        (b"#" * 1_000_001, "is not a map.yaml: it is larger than 1000000 bytes"),
        # Nested lists that grow tenfold a line are shown in short.
        (
            b"a: &a [x,x,x,x,x,x,x,x,x,x]\n"
            + b"".join(b"%c: &%c [%s]\n" % (c, c, b",".join([b"*%c" % (c - 1)] * 10))
                       for c in b"bcdefghi")
            + b"image: *i\nresolution: *i\norigin: *i\n",
            "origin must be [x, y, yaw], finite numbers, got [",
        ),
    ],
)  # fmt: skip
def test_what_is_no_map_yaml(text, message, tmp_path):
    path = tmp_path / "map.yaml"
    path.write_bytes(text)
    assert complaint(sm.read_map, path, tmp_path).startswith(message)


def png(*, cut=None):
    def write(path):
        noise = np.random.default_rng(0).integers(256, size=(40, 40), dtype=np.uint8)
        Image.fromarray(noise).save(path, format="PNG")
        path.write_bytes(path.read_bytes()[:cut])

    return write


PGM_HEAD = "is not a readable image: its PGM header is damaged"
BAD_IMAGES = [
    (b"", "is not a readable image (Unidentified"),
    (b"hello", "is not a readable image (Unidentified"),
    (b"P5", PGM_HEAD),
    (b"P5\n2 2\n", PGM_HEAD),
    (b"P5\n2 -2\n255\n" + bytes(4), PGM_HEAD),
    (b"P5 2 2 1234567890\n" + bytes(4), PGM_HEAD),
    (b"P5\n2 2\n0\n" + bytes(4), "is not a readable image: its maximum must be 1 to 65535, got 0"),
    (b"P5\n2 2\n70000\n" + bytes(8), "is not a readable image: its maximum must be 1 to 65535"),
    (b"P5\n0 2\n255\n", "must have 1 to 100000000 pixels, got 0 x 2"),
    (b"P5\n99999 99999\n255\n", "must have 1 to 100000000 pixels, got 99999 x 99999"),
    (b"P5\n2 2\n255\n" + bytes(3), "is truncated: it must have 4 pixels, got 3"),
    (b"P5\n2 2\n256\n" + bytes(7), "is truncated: it must have 4 pixels, got 3"),
    (b"P5\n2 1\n100\n\x00\x65", "is damaged: its values must be 0 to 100, got 101"),
    (b"P2\n2 2\n255\n1 2 3 # 4\n", "is truncated: it must have 4 pixels, got 3"),
    (b"P2\n2 1\n255\n1 two\n", "is damaged: its values must be whole numbers"),
    (b"P2\n2 1\n255\n1 2.5\n", "is damaged: its values must be whole numbers"),
    (b"P2\n2 1\n255\n1 -2\n", "is damaged: its values must be 0 to 255, got -2"),
    (b"P2\n2 1\n255\n1 99999999999999999999\n", "is damaged: its values must be whole numbers"),
    (png(cut=900), "is not a readable image ("),
    (png(cut=30), "is not a readable image ("),
]


@pytest.mark.parametrize(("image", "message"), BAD_IMAGES)
def test_bad_images(image, message, tmp_path):
    if callable(image):
        image(tmp_path / "map.pgm")
    else:
        (tmp_path / "map.pgm").write_bytes(image)
    said = complaint(sm.read_map, write_yaml(tmp_path), tmp_path)
    assert said.startswith(f"image: FOLDER/map.pgm: {message}")


def test_an_absurd_png_is_refused_by_its_header(tmp_path):
    Image.fromarray(np.zeros((1, 1), np.uint8)).save(tmp_path / "map.png")
    whole = bytearray((tmp_path / "map.png").read_bytes())
    import zlib

    for side in (11_000, 100_000):
        whole[16:24] = side.to_bytes(4, "big") * 2
        whole[29:33] = zlib.crc32(whole[12:29]).to_bytes(4, "big")
        (tmp_path / "map.png").write_bytes(whole)
        said = complaint(sm.read_map, write_yaml(tmp_path, image="map.png"), tmp_path)
        assert said.startswith("image: FOLDER/map.png: ")


def test_other_files(tmp_path):
    write_pgm(tmp_path / "map.pgm", [[0]])
    for name, message in [
        ("map.pgm", "is an image: give the map.yaml that it belongs to"),
        ("gone.yaml", "no such file"),
        ("gone", "no such file"),
    ]:
        assert complaint(sm.read_map, tmp_path / name, tmp_path) == message
    (tmp_path / "folder.yaml").mkdir()
    assert complaint(read_ros_map, tmp_path / "folder.yaml", tmp_path) == "is not a file"
