"""Campaigns in parts: on any executor, and in any order, the rows are the same."""

import multiprocessing
import shutil
import subprocess
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest
import rexrov
from conftest import COSIM
from rexrov import CosimError, system_path

FILE = f"""seeds = 3
stop-time = 2
output-interval = 0.5
systems.paper = "{system_path("paper")}"
replacements.dynamic = {{}}
replacements.kinematic = {{ ekf = "{rexrov.fmu_path("EkfKinematic")}" }}
dispersions."vehicle.current.east" = {{ kind = "normal", mean = 0, sigma = 0.05 }}
figures.ate = {{ kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose" }}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    file = tmp_path_factory.mktemp("campaign") / "filters.toml"
    file.write_text(FILE)
    return file


@pytest.fixture(scope="module")
def wanted(file):
    return table(rexrov.campaign(file, output_dir=file.parent / "one", jobs=1).folder)


def table(folder):
    """The rows, byte for byte, except for their durations."""
    lines = (folder / "runs.csv").read_bytes().splitlines()
    assert lines[0].endswith(b",cpu_ms")
    return [line.rpartition(b",")[0] for line in lines]


def cosim(*arguments, **environment):
    command = [COSIM, "campaign", "--quiet", "--csv", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment or None)


def pool(folder):
    return ProcessPoolExecutor(2, multiprocessing.get_context("spawn"))


def threads(folder):
    return ThreadPoolExecutor(3)


def dask(folder):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    return distributed.Client(cluster).get_executor()


def submitit(folder):
    executor = pytest.importorskip("submitit").LocalExecutor(folder / "submitit")
    executor.update_parameters(timeout_min=10)
    return executor


@pytest.mark.parametrize("executor", [pool, threads, dask, submitit])
def test_an_executor_makes_the_rows_of_one_process(tmp_path, file, wanted, executor):
    with executor(tmp_path) if executor in (pool, threads) else nothing(executor(tmp_path)) as running:
        result = rexrov.campaign(file, output_dir=tmp_path / "results", executor=running, shards=3)
    assert table(result.folder) == wanted and len(wanted) == 7
    assert result.summary["runs"] == 6 and result.verdict == "none"


class nothing:
    """An object that need not be closed, or closes itself."""

    def __init__(self, what):
        self.what = what

    def __enter__(self):
        return self.what

    def __exit__(self, *_):
        client = getattr(self.what, "_client", None)
        if client is not None:
            client.cluster.close()
            client.close()


def test_parts_are_made_by_a_scheduler_and_merged(tmp_path, file, wanted):
    slurm = {"SLURM_ARRAY_TASK_MIN": "4", "SLURM_ARRAY_TASK_COUNT": "2"}
    for task in ("4", "5"):
        done = cosim(file, "--shard=auto", f"--output-dir={tmp_path}", **slurm, SLURM_ARRAY_TASK_ID=task)
        assert done.returncode == 0, done.stderr
    done = cosim("--merge", *sorted(tmp_path.glob("shard-*")), f"--output-dir={tmp_path / 'all'}")
    assert (done.returncode, done.stderr) == (0, "")
    assert table(tmp_path / "all") == wanted
    done = cosim(file, "--shard=auto/7", f"--output-dir={tmp_path}", JOB_COMPLETION_INDEX="7")
    assert done.returncode == 2 and "there is no part 8 of 7" in done.stderr


def test_what_is_missing_or_does_not_agree_is_told(tmp_path, file):
    for part in ("1/3", "2/3"):
        assert cosim(file, f"--shard={part}", f"--output-dir={tmp_path}").returncode == 0
    parts = sorted(tmp_path.glob("shard-*"))
    done = cosim("--merge", *parts, f"--output-dir={tmp_path / 'all'}")
    assert "2 of 6 runs are missing" in done.stderr and "run the shards again" in done.stderr
    # Duplicate rows do no harm, different ones do.
    copy = shutil.copytree(parts[0], tmp_path / "copy")
    done = cosim("--merge", *parts, copy, f"--output-dir={tmp_path / 'all'}")
    assert "runs are missing" in done.stderr
    log = copy / "runs.jsonl"
    log.write_text(log.read_text().replace('"status":"ok"', '"status":"crashed"', 1))
    done = cosim("--merge", *parts, copy, f"--output-dir={tmp_path / 'other'}")
    assert "differs between" in done.stderr and "E403" in done.stderr
    manifest = copy / "campaign.json"
    manifest.write_text(manifest.read_text().replace("seed = 0", "seed = 1"))
    done = cosim("--merge", *parts, copy, f"--output-dir={tmp_path / 'other'}")
    assert "the existing results belong to another campaign" in done.stderr and "seed = 1" in done.stderr


def test_an_error_of_a_part_is_the_campaign_s(tmp_path, file):
    wrong = file.with_name("wrong.toml")
    wrong.write_text(FILE.replace("vehicle.current.east", "vehicle.current.esat"))
    with pytest.raises(CosimError, match="did you mean .current.east"), ThreadPoolExecutor(1) as executor:
        rexrov.campaign(wrong, output_dir=tmp_path, executor=executor, shards=2)
