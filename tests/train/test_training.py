"""The training of the learned mapper, as small as can be; needs the extra `train`."""

import numpy as np
import pytest
import torch

from mapper_training.calibrating import fit_two_numbers
from mapper_training.examples import Example, logs_of, make_examples
from mapper_training.exporting import weights_of
from mapper_training.fitting import Fitting, _Crops, _turn, fit, logits_of
from mapper_training.learning_curve import learning_curve
from mapper_training.network import UNet
from mapper_training.rooms_and_logs import make_logs
from sonarmap.learned.channels import CHANNELS
from sonarmap.learned.network import logits
from sonarmap.learned.weights import Weights
from worlds import HIDDEN

SMALL = Fitting(widths=(4, 6), steps=3, batch=2, crop=16, warm=1)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return the examples of the smallest data there are, and the folder of one of the sets."""
    folder = tmp_path_factory.mktemp("mapper")
    sets = make_logs(folder / "logs", rooms=10, seed=5, workers=1)[-1:]
    files = make_examples(sets, folder / "examples", seed=5, workers=1)
    return [Example.load(file) for file in files], sets[0]


def example(rng, shape=(30, 40)):
    return Example(
        rng.random((len(CHANNELS), *shape)).astype(np.float16),
        rng.integers(3, size=shape).astype(np.uint8),
        rng.random(shape) < 0.5,
        "room",
        "group",
        "train",
    )


def test_the_forward_pass_is_that_of_the_training_library(rng, tmp_path):
    torch.manual_seed(0)
    net = UNet(len(CHANNELS), (8, 12, 16, 20))
    # Statistics as after training, not those of a new network.
    for module in net.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.running_mean.uniform_(-0.5, 0.5)
            module.running_var.uniform_(0.5, 2)
            module.weight.data.uniform_(0.5, 1.5)
            module.bias.data.uniform_(-0.5, 0.5)
    # Kernels are kept as float16: compared with a network whose folded kernels have those values.
    net.eval()
    weights_of(net).save(tmp_path / "w.npz")
    weights = Weights.load(tmp_path / "w.npz")
    rounded = UNet(len(CHANNELS), (8, 12, 16, 20)).eval()
    for pairs, sides in ((weights.down, rounded.down), (weights.up, rounded.up)):
        for pair, side in zip(pairs, sides, strict=True):
            parts = list(side)
            for layer, convolution, norm in zip(pair, parts[0::3], parts[1::3], strict=True):
                kernel = layer.kernel.reshape(len(layer.kernel), 3, 3, -1).transpose(0, 3, 1, 2)
                convolution.weight.data = torch.from_numpy(kernel.copy())
                norm.running_mean.zero_()
                norm.running_var.fill_(1 - norm.eps)
                norm.bias.data = torch.from_numpy(layer.bias[:, 0])
    rounded.head.load_state_dict(net.head.state_dict())
    x = rng.random((len(CHANNELS), 43, 58)).astype(np.float32)
    np.testing.assert_allclose(logits(weights, x), logits_of(rounded, x), atol=1e-4)
    # And the rounding itself moves P by little.
    assert np.abs(logits(weights, x) - logits_of(net, x)).max() < 0.02


def test_the_same_seed_makes_the_same_weights_also_when_stopped(rng, tmp_path):
    examples = [example(rng) for _ in range(3)]
    whole = fit(examples, examples, SMALL)
    again = fit(examples, examples, SMALL)
    checkpoint = tmp_path / "c.pt"

    def stop(progress):
        if progress.step == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit(examples, examples, SMALL, checkpoint=checkpoint, report_every=1, on_progress=stop)
    resumed = fit(examples, examples, SMALL, checkpoint=checkpoint)
    for other in (again, resumed):
        for ours, theirs in zip(
            whole.state_dict().values(), other.state_dict().values(), strict=True
        ):
            assert torch.equal(ours, theirs)


def test_turned_crops_have_turned_directions(rng):
    names = list(CHANNELS)
    for _ in range(20):
        angle = rng.uniform(0, 2 * np.pi)
        x = np.zeros((len(CHANNELS), 5, 5), np.float32)
        # An arrow, drawn as the cells that it points from and to.
        x[names.index("cos_2")], x[names.index("sin_2")] = np.cos(2 * angle), np.sin(2 * angle)
        x[0, 2, 2], x[0, 2, 4], x[0, 4, 2] = 1, 2, 3  # the middle, along x, along y
        _turn(rng, x, np.zeros((5, 5), np.uint8), np.zeros((5, 5), np.float32))
        ends = {}
        for value in (2, 3):
            row, col = np.argwhere(x[0] == value)[0] - 2
            ends[value] = np.array([col, row]) / 2  # as x and y
        along = np.cos(angle) * ends[2] + np.sin(angle) * ends[3]
        turned = np.arctan2(along[1], along[0])
        assert x[names.index("cos_2"), 1, 1] == pytest.approx(np.cos(2 * turned), abs=1e-5)
        assert x[names.index("sin_2"), 1, 1] == pytest.approx(np.sin(2 * turned), abs=1e-5)


def test_crops_are_the_same_for_the_same_step(rng):
    examples = [example(rng), example(rng, (9, 50))]
    first, again = (_Crops(examples, SMALL).of_step(7) for _ in range(2))
    for ours, theirs in zip(first, again, strict=True):
        assert torch.equal(ours, theirs)
    assert first[0].shape == (2, len(CHANNELS), 16, 16)
    # What lies beyond a small example is hidden: it has no weight.
    assert (first[2] <= 1).all()


def test_two_numbers_are_found_again(rng):
    logit = rng.normal(size=50_000) * 3
    occupied = rng.random(50_000) < 1 / (1 + np.exp(-(0.7 * logit - 0.4)))
    found = fit_two_numbers(logit, occupied)
    assert found.scale == pytest.approx(0.7, abs=0.02)
    assert found.offset == pytest.approx(-0.4, abs=0.03)


def test_data_are_made_of_rooms_that_are_held_out_as_rooms(data):
    examples, folder = data
    assert len(examples) == len(list(logs_of(folder))) >= 10
    rooms = {split: {e.room for e in examples if e.split == split} for split in ("train",)}
    assert rooms["train"].isdisjoint({e.room for e in examples if e.split != "train"})
    for each in examples:
        assert each.channels.shape == (len(CHANNELS), *each.state.shape)
        assert each.observable.any()
        assert not each.observable[each.state == HIDDEN].any()


def test_a_learning_curve_is_resumed(rng, tmp_path, monkeypatch):
    train, held_out = [example(rng) for _ in range(8)], [example(rng) for _ in range(2)]
    told, file = [], tmp_path / "curve.jsonl"
    asked = {"room_shares": (0.25, 1), "widths": ((4, 6), (6, 8)), "on_point": told.append}
    points = learning_curve(train, held_out, SMALL, file, **asked)
    assert [(p.rooms, p.widths) for p in points] == [(2, (4, 6)), (8, (4, 6)), (8, (6, 8))]
    assert points[2].parameters > points[1].parameters == points[0].parameters
    assert told == points
    # Of what is there nothing is fitted again, only what was cut off.
    file.write_text("".join(file.read_text().splitlines(keepends=True)[:2]))
    fitted = []

    def counted(some, held_out, fitting):
        fitted.append((len(some), fitting.widths))
        return fit(some, held_out, fitting)

    monkeypatch.setattr("mapper_training.learning_curve.fit", counted)
    assert learning_curve(train, held_out, SMALL, file, **asked) == points
    assert fitted == [(8, (6, 8))]
