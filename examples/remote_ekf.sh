#!/bin/sh
# How do I run the filter on another machine? With a worker there. Here both are this machine; for another
# machine only the address changes, and the folder keys/robot is copied to the robot.
#
#     sh remote_ekf.sh paper.ssd FOLDER_OF_FMUS
set -eu
system=$1 fmus=$2
address=127.0.0.1 port=17447

# An authority, and a folder of keys for each member.
rm -rf keys
cosim keys keys --worker robot --host $address

# On the robot: serves runs that have the authority's certificate, for these FMUs only.
cosim worker --name robot --connect tls/$address:$port --credentials keys/robot --allow "$fmus" &
worker=$!
trap 'kill $worker' EXIT

# At the desk: everything here except the filter.
cosim run "$system" --stop-time 60 --output-file remote.csv --place ekf=robot \
      --distributed --listen tls/$address:$port --credentials keys/orchestrator --wait 60

# The same run in one process gives the same bits.
cosim run "$system" --stop-time 60 --output-file local.csv --quiet
cosim verify remote.csv local.csv
