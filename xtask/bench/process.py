"""Wall-clock milliseconds (minimum and median), processor milliseconds (minimum) and peak memory in MB of a
command as a whole process. usage: process.py REPETITIONS COMMAND..."""

import os
import statistics
import sys
import time

walls, processor, memory = [], [], 0
devnull = os.open(os.devnull, os.O_WRONLY)
for _ in range(int(sys.argv[1])):
    begun = time.perf_counter()
    actions = [(os.POSIX_SPAWN_DUP2, devnull, 1), (os.POSIX_SPAWN_DUP2, devnull, 2)]
    process = os.posix_spawn(sys.argv[2], sys.argv[2:], os.environ, file_actions=actions)
    _, status, usage = os.wait4(process, 0)
    walls.append(1e3 * (time.perf_counter() - begun))
    if status:
        sys.exit(f"{sys.argv[2:]} failed")
    processor.append(1e3 * (usage.ru_utime + usage.ru_stime))
    memory = max(memory, usage.ru_maxrss / 1024)
print(min(walls), statistics.median(walls), min(processor), memory)
