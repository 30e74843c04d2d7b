"""Windows of the readings of a data set."""

import pickle
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support import random_log

import sonarmap as sm
from sonarmap import InputError

SIZES = {"train": (40, 7, 25), "test": (12,)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Four logs of different length and a manifest, as `sonarbed dataset` writes them."""
    folder = tmp_path_factory.mktemp("data")
    rows = []
    rng = np.random.default_rng(3)
    for split, sizes in SIZES.items():
        for i, size in enumerate(sizes):
            file = f"logs/split={split}/room=r{i}/{i:05d}-x.parquet"
            random_log(rng, size, truth=True).write(folder / file)
            rows.append({"file": file, "split": split, "readings": size})
    pq.write_table(pa.Table.from_pylist(rows), folder / "manifest.parquet")
    return folder


def test_windows_are_the_rows_of_the_logs(folder):
    train = sm.SonarDataset(folder, split="train", window=10)
    assert len(train) == 4 + 0 + 2
    assert "6 windows of 3 logs" in repr(train)
    seen = [train.origin(i) for i in range(len(train))]
    assert [first for _, first in seen] == [0, 10, 20, 30, 0, 10]
    for i, (file, first) in enumerate(seen):
        log = sm.read_log(folder / file)
        window = train[i]
        assert "truth_surface" not in window
        for name in log.DTYPES:
            np.testing.assert_array_equal(window[name], getattr(log, name)[first : first + 10])
        np.testing.assert_array_equal(window["truth_cause"], log.truth.cause[first : first + 10])
        assert window["truth_cause"].dtype == np.int8


def test_strides_and_whole_logs(folder):
    assert len(sm.SonarDataset(folder, "train", window=10, stride=3)) == 11 + 0 + 6
    assert len(sm.SonarDataset(folder, "train", window=7, stride=100)) == 3
    whole = sm.SonarDataset(folder)
    assert [len(window["range_m"]) for window in whole] == [40, 7, 25, 12]
    assert len(whole[-1]["range_m"]) == 12


def test_columns_that_are_computed(folder):
    names = ["axis_rad", "sensor_x_m", "sensor_y_m", "truth_surface"]
    data = sm.SonarDataset(folder, "test", columns=names)
    log = sm.read_log(folder / data.origin(0)[0])
    window = data[0]
    assert list(window) == names
    np.testing.assert_array_equal(window["axis_rad"], log.axis_rad)
    np.testing.assert_array_equal(window["sensor_x_m"], log.sensor_xy_m[:, 0])
    np.testing.assert_array_equal(window["truth_surface"], log.truth.surface)
    assert list(sm.SonarDataset(folder, columns=["axis_rad"])[0]) == ["axis_rad"]


def test_it_keeps_few_logs_and_pickles_without_them(folder):
    data = sm.SonarDataset(folder, kept_logs=2)
    windows = list(data)
    assert len(data._kept) == 2
    windows[3]["range_m"][:] = -1  # a window is the caller's own
    again = pickle.loads(pickle.dumps(data))
    assert len(again._kept) == 0
    assert len(again) == 4
    np.testing.assert_array_equal(again[3]["range_m"], data[3]["range_m"])
    assert (again[3]["range_m"] != -1).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"split": "tset"}, "split 'tset' is unknown; did you mean 'test'?"),
        ({"window": 0}, "window must be >= 1, got 0"),
        ({"window": 2.5}, "window must be a whole number, got 2.5"),
        ({"window": 50}, "no log of split None has 50 readings: give a smaller window"),
        ({"stride": 3}, "stride needs a window"),
        ({"window": 5, "stride": 0}, "stride must be >= 1, got 0"),
        ({"columns": ["rnage_m"]}, "column 'rnage_m' is unknown; did you mean 'range_m'?"),
        ({"columns": []}, "columns must be a list of at least one name"),
        ({"columns": "range_m"}, "columns must be a list of at least one name"),
        ({"kept_logs": 0}, "kept_logs must be >= 1, got 0"),
    ],
)
def test_bad_arguments(folder, arguments, message):
    with pytest.raises(InputError) as caught:
        sm.SonarDataset(folder, **arguments)
    assert message in str(caught.value)


def test_bad_folders_and_places(folder, tmp_path):
    with pytest.raises(InputError, match=r"is no data set: it has no manifest\.parquet"):
        sm.SonarDataset(tmp_path)
    data = sm.SonarDataset(folder, "test", window=4)
    for index in (3, -4):
        with pytest.raises(IndexError, match="index must be within -3 and 2"):
            data[index]
    with pytest.raises(TypeError, match="index must be a whole number"):
        data["x"]
    (tmp_path / "manifest.parquet").write_bytes((folder / "manifest.parquet").read_bytes())
    with pytest.raises(InputError, match=r"00000-x\.parquet: no such file"):
        sm.SonarDataset(tmp_path)[0]
    (tmp_path / "manifest.parquet").write_bytes(b"x")
    with pytest.raises(InputError, match=r"manifest\.parquet: cannot be read"):
        sm.SonarDataset(tmp_path)


def test_it_needs_neither_a_simulator_nor_pytorch(folder):
    script = (
        "import sys, sonarmap as sm\n"
        f"assert len(sm.SonarDataset({str(folder)!r}, window=5)[0]['range_m']) == 5\n"
        "sys.exit(bool({'sim', 'worlds', 'torch', 'fsspec', 'numba'} & set(sys.modules)))\n"
    )
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0


def test_a_loader_of_pytorch_takes_it_as_it_is(folder):
    pytest.importorskip("torch", reason="PyTorch is not installed")
    # In a process of its own, whose workers inherit nothing of the tests.
    script = (
        "import sys, torch, sonarmap as sm\n"
        "from torch.utils.data import DataLoader\n"
        "if __name__ == '__main__':\n"
        f"    data = sm.SonarDataset({str(folder)!r}, 'train', window=5)\n"
        "    for method in ('fork', 'spawn'):\n"
        "        loader = DataLoader(data, batch_size=4, shuffle=True, num_workers=2,\n"
        "                            multiprocessing_context=method)\n"
        "        batches = list(loader)\n"
        "        assert sum(len(b['range_m']) for b in batches) == len(data) == 14\n"
        "        assert batches[0]['truth_cause'].shape == (4, 5)\n"
        "        assert isinstance(batches[0]['range_m'], torch.Tensor)\n"
    )
    path = folder / "loading.py"
    path.write_text(script)
    done = subprocess.run([sys.executable, path], capture_output=True, text=True)
    path.unlink()
    assert done.returncode == 0, done.stderr
