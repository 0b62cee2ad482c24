"""Prints the recorded values of a distributed run: observe.py tcp/127.0.0.1:7447"""
import json, sys, zenoh

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps(sys.argv[1:2]))
with zenoh.open(config) as session, session.declare_subscriber("cosim/1/*/*") as messages:
    for message in messages:
        content = json.loads(message.payload.to_bytes())
        if "values" in content:
            print(content["time"], json.dumps(content["values"]), sep="\t", flush=True)
        elif content["ended"]:
            break
