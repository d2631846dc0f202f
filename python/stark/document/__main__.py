"""``python -m stark.document``: the JSON Schema of scene documents."""

import json

from .format import schema

if __name__ == "__main__":
    print(json.dumps(schema(), indent=1))
