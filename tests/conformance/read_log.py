"""Reads a log with the Python reader of the MCAP project and says what it finds, as JSON."""
import json
import struct
import sys

import jsonschema
from mcap.reader import NonSeekingReader, make_reader

with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    summary = reader.get_summary()
    found = {"topics": {}, "metadata": {}, "sample_time_bits": [], "first_log_times": []}
    validators = {}
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        text = json.loads(schema.data)
        jsonschema.Draft202012Validator.check_schema(text)
        validators[channel.topic] = jsonschema.Draft202012Validator(text)
        found["topics"][channel.topic] = {
            "count": 0, "streamed": 0, "encoding": channel.message_encoding, "schema": schema.encoding, "invalid": [],
            "counted": summary.statistics.channel_message_counts.get(channel.id, 0),
        }
        if channel.topic == "/sample":
            found["units"] = {name: field["description"] for name, field in text["properties"].items()}
    for schema, channel, message in reader.iter_messages():
        topic = found["topics"][channel.topic]
        topic["count"] += 1
        payload = json.loads(message.data)
        topic["invalid"] += [error.message for error in validators[channel.topic].iter_errors(payload)][:3]
        if channel.topic == "/sample":
            found["sample_time_bits"].append(struct.pack(">d", payload["time"]).hex())
            if len(found["first_log_times"]) < 4:
                found["first_log_times"].append(message.log_time)
    for record in reader.iter_metadata():
        if record.name == "run":
            found["metadata"] = record.metadata

with open(sys.argv[1], "rb") as file:
    for schema, channel, message in NonSeekingReader(file).iter_messages():
        found["topics"][channel.topic]["streamed"] += 1

for topic in found["topics"].values():
    assert topic["count"] == topic["counted"], topic
json.dump(found, sys.stdout)
