"""Processes of one ROS domain, and a listener."""

import os
import subprocess
import sys

import pytest

from tests.ros.domain import DOMAIN


@pytest.fixture
def listener():
    from tests.ros.listening import Listener

    heard = Listener()
    yield heard
    heard.close()


@pytest.fixture
def start(tmp_path):
    """Start processes of one ROS domain; they end with the test."""
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(DOMAIN),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_HOME": str(tmp_path),
        "ROS_LOG_DIR": str(tmp_path / "log"),
    }
    processes = []

    def begin(*words):
        process = subprocess.Popen(
            [sys.executable, *words], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        processes.append(process)
        return process

    yield begin
    for process in processes:
        process.kill()
        process.communicate()
