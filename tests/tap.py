"""What tests/run and tests/web/run have in common: programs that report in TAP, and lines of counts.
SPDX-License-Identifier: GPL-3.0-or-later"""
import subprocess


def output_of(command, timeout_s, **options):
    """What a program printed, and its exit status; -1 where it did not end."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=timeout_s,
                              **options)
        return done.stdout, done.returncode
    except subprocess.TimeoutExpired:
        return f"no end after {timeout_s} s\n", -1


def count_crash(counts, status):
    """A program that crashed, or whose sanitizer found something when its tests were over, or that had no test, has failed."""
    crashed = bool(status and not counts["failed"] or not sum(counts.values()))
    counts["failed"] += crashed
    return crashed


def summary(counts):
    return f"{counts['passed']} passed, {counts['failed']} failed" + (f", {counts['skipped']} skipped" if counts["skipped"] else "")
