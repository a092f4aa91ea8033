"""Compares two sets of descriptors: whether clients of the old one work with servers of the new one."""
from google.protobuf import descriptor_pb2


def read(file):
    return descriptor_pb2.FileDescriptorSet.FromString(file.read_bytes())


def things_of(descriptors):
    """{full name: message, enum or service} of the project's own files."""
    found = {}

    def add(prefix, kind, things):
        for thing in things:
            name = f"{prefix}.{thing.name}"
            found[name] = (kind, thing)
            if kind == "message":
                add(name, "message", thing.nested_type)
                add(name, "enum", thing.enum_type)

    for file in descriptors.file:
        if file.package.startswith("palpate."):
            add(file.package, "message", file.message_type)
            add(file.package, "enum", file.enum_type)
            add(file.package, "service", file.service)
    return found


def of_field(field, message):
    oneof = message.oneof_decl[field.oneof_index].name if field.HasField("oneof_index") else ""
    return {"name": field.name, "type": field.type, "of": field.type_name, "label": field.label, "oneof": oneof,
            "optional": field.proto3_optional, "packed": field.options.packed}


def parts_of(kind, thing):
    """{number or name: what a client relies on}."""
    if kind == "message":
        return {field.number: of_field(field, thing) for field in thing.field}
    if kind == "enum":
        return {value.number: {"name": value.name} for value in thing.value}
    return {method.name: {"input": method.input_type, "output": method.output_type, "client streaming": method.client_streaming,
                          "server streaming": method.server_streaming} for method in thing.method}


def breaks(old, new):
    """A line for each thing of `old` that `new` has no more, or has otherwise."""
    found, now = [], things_of(new)
    for name, (kind, thing) in things_of(old).items():
        if name not in now or now[name][0] != kind:
            found.append(f"{kind} {name} is gone")
            continue
        present = parts_of(*now[name])
        for number, facts in parts_of(kind, thing).items():
            if number not in present:
                found.append(f"{name}: {number} ({facts.get('name', number)}) is gone")
            else:
                found += [f"{name}: {number}: {what} was {value!r}, is {present[number][what]!r}" for what, value in facts.items()
                          if present[number][what] != value]
    return found
