"""Machine code of the symbolic engine against capstone: every instruction form with its registers, bases and
displacements, and whole kernels executed instruction by instruction from the disassembly. This also covers
AVX-512 on machines that do not have it."""

import ctypes
import ctypes.util
import json
import math
import os
import pathlib
import subprocess

import pytest

capstone = pytest.importorskip("capstone")
np = pytest.importorskip("numpy")

ROOT = pathlib.Path(__file__).resolve().parents[2]


def find_program():
    named = os.environ.get("STARK_TEST_SYMBOLIC")
    if named:
        return pathlib.Path(named)
    native = [p for p in ROOT.glob("build/**/tests/test_symbolic") if "aarch64" not in p.parts]
    found = sorted(native, key=lambda p: p.stat().st_mtime)
    return found[-1] if found else None


def written(tmp_path_factory, variable, case):
    """What a case of the C++ tests writes to the file that an environment variable names."""
    program = find_program()
    if program is None:
        pytest.skip("the C++ tests are not built")
    path = tmp_path_factory.mktemp("code") / "dump"
    subprocess.run(
        [program, f"--test-case={case}*"],
        check=True,
        capture_output=True,
        env={**os.environ, variable: str(path)},
    )
    return path.read_text()


@pytest.fixture(scope="module")
def dump(tmp_path_factory):
    return json.loads(written(tmp_path_factory, "STARK_MACHINE_CODE_DUMP", "kernels are written"))


@pytest.fixture(scope="module")
def instructions(tmp_path_factory):
    text = written(tmp_path_factory, "STARK_INSTRUCTION_DUMP", "instruction forms")
    return [line.split() for line in text.splitlines()]


def disassembler(detail=True):
    md = capstone.Cs(capstone.CS_ARCH_X86, capstone.CS_MODE_64)
    md.detail = detail
    return md


PREDICATES = {"vcmplt_oqpd": 0x11, "vcmple_oqpd": 0x12}


def plain(instruction, operands):
    """Mnemonic, operands and comparison predicate, with the predicate taken out of the mnemonic."""
    name = instruction.mnemonic
    if name in PREDICATES:
        return "vcmppd", operands, PREDICATES[name]
    if name == "vcmppd":  # predicates without a name of their own stay as a number
        return name, operands, {"lt_oq": 0x11, "le_oq": 0x12}.get(name)
    return name, operands, None


ONE_SOURCE = {"vsqrtpd", "vrndscalepd", "vroundpd", "vmovupd", "vmovapd", "vbroadcastsd", "store", "vpmovm2q"}
NAMED_PREDICATES = {0x11: "vcmplt_oqpd", 0x12: "vcmple_oqpd"}


def number(value):
    """As capstone writes it."""
    size = hex(abs(value)) if abs(value) > 9 else str(abs(value))
    return "-" + size if value < 0 else size


def memory(base, displacement):
    d = int(displacement)
    return f"[{base}]" if d == 0 else f"[{base} {'-' if d < 0 else '+'} {number(abs(d))}]"


def last_operand(name, vector, text):
    if ":" not in text:
        return f"k{text}" if name == "vpmovm2q" else f"{vector}{text}"
    base, displacement, kind = text.split(":")
    if kind == "b":
        return f"qword ptr {memory(base, displacement)}{{1to8}}"
    return f"{'qword' if name == 'vbroadcastsd' else vector + 'word'} ptr {memory(base, displacement)}"


def expected_text(wide, name, reg, first, second, immediate):
    """Mnemonic and operands in the notation of Intel."""
    if reg == "general":
        if name == "lea":
            return name, f"{first}, {memory('rip', second.split(':')[1])}"
        shown = number(int(second)) if second.lstrip("-").isdigit() else second
        return name, first if second == "-" else f"{first}, {shown}"
    vector = "zmm" if wide == "1" else "ymm"
    last, value = last_operand(name, vector, second), int(immediate)
    if name == "store":
        return "vmovupd", f"{last}, {vector}{reg}"
    if name in ("vpsllq", "vpsrlq"):  # the target is named in the second place
        return name, f"{vector}{first}, {last}, {number(value)}"
    mask = name == "vcmppd" and wide == "1"
    operands = [f"{'k' if mask else vector}{reg}"]
    if name not in ONE_SOURCE:
        operands.append(f"{vector}{first}")
    operands.append(last)
    if name == "vblendvpd":
        operands.append(f"ymm{value >> 4}")
    elif name == "vcmppd":
        name = NAMED_PREDICATES[value]
    elif value >= 0:
        operands.append(number(value))
    return name, ", ".join(operands)


def test_every_instruction_form(instructions):
    assert len(instructions) > 250_000
    code = bytes.fromhex("".join(line[-1] for line in instructions))
    decoded = disassembler(detail=False).disasm_lite(code, 0)
    address = 0
    for line in instructions:
        start, size, name, operands = next(decoded, (address, 0, "nothing", ""))
        assert (start, size) == (address, len(line[-1]) // 2), (line, name, operands)
        assert (name, operands) == expected_text(*line[:-1]), line
        address += size


def test_forms_cover_the_operands(instructions):
    """The cross products are what they claim to be."""
    vectors = [line for line in instructions if line[2] != "general"]
    for wide, count in (("0", 16), ("1", 32)):
        registers = {str(k) for k in range(count)}
        mine = [line for line in vectors if line[0] == wide]
        for name in {line[1] for line in mine}:
            forms = [line for line in mine if line[1] == name]
            if name not in ("vpsllq", "vpsrlq") and not (name == "vcmppd" and wide == "1"):
                assert {line[2] for line in forms} == registers, (wide, name)
            places = [tuple(line[4].split(":")) for line in forms if ":" in line[4]]
            if places:
                assert len({(base, d) for base, d, _ in places}) >= 16 * 26, (wide, name)
            if name not in ("vpmovm2q", "store", "vbroadcastsd"):
                assert registers <= {line[4] for line in forms}, (wide, name)
        cube = {tuple(line[2:5]) for line in mine if line[1] == "vaddpd" and ":" not in line[4]}
        assert len(cube) == count**3


libm = ctypes.CDLL(ctypes.util.find_library("m"))
libm.fma.restype = ctypes.c_double
libm.fma.argtypes = [ctypes.c_double] * 3


def fma(a, b, c):
    return np.array([libm.fma(x, y, z) for x, y, z in zip(a, b, c, strict=True)])


class Machine:
    """Executes the few instructions that kernels use, on vectors of 64-bit lanes."""

    def __init__(self, kernel):
        self.lanes = 8 if kernel["wide"] else 4
        self.code = bytes.fromhex(kernel["hex"])
        self.blocks = kernel["blocks"]
        self.base = {}
        self.memory = {}
        uniforms = np.repeat(np.array(kernel["uniforms"], dtype=np.uint64), 1 if kernel["wide"] else 4)
        self.place("rdi", 0x10000000, np.array(kernel["unknowns"], dtype=np.uint64))
        self.place("rsi", 0x20000000, np.array(kernel["elements"], dtype=np.uint64))
        self.place("rdx", 0x30000000, uniforms)
        self.place("rcx", 0x40000000, np.zeros(len(kernel["expected"]), dtype=np.uint64))
        self.place("r9", 0x50000000, np.zeros(max(1, kernel["spills"]) * self.lanes, dtype=np.uint64))
        padded = self.code + bytes(-len(self.code) % 8)
        self.memory[0] = np.frombuffer(padded, dtype=np.uint64)
        self.gpr = {**self.base, "r8": self.blocks, "rax": None, "r10": None}
        self.vector = {}
        self.mask = None
        self.zero = False

    def place(self, register, address, words):
        self.base[register] = address
        self.memory[address] = words

    def locate(self, address, count):
        start = address & 0x70000000
        words = self.memory[start]
        offset = address - start
        assert offset % 8 == 0 and offset >= 0 and offset // 8 + count <= len(words), hex(address)
        return words, offset // 8

    def read(self, address, count):
        words, k = self.locate(address, count)
        return words[k : k + count].copy()

    def value(self, i, o):
        if o.type == capstone.x86.X86_OP_REG:
            return self.vector[self.number(i.reg_name(o.reg))]
        address = self.address(i, o)
        if "{1to8}" in i.op_str or i.mnemonic == "vbroadcastsd":
            return np.repeat(self.read(address, 1), self.lanes)
        return self.read(address, self.lanes)

    def address(self, i, o):
        base = i.reg_name(o.mem.base)
        start = i.address + i.size if base == "rip" else self.gpr[base]
        return start + o.mem.disp

    @staticmethod
    def number(name):
        assert name[:3] in ("ymm", "zmm"), name
        return int(name[3:])

    def run(self):
        by_address = {i.address: i for i in disassembler().disasm(self.code, 0)}
        address, steps = 0, 0
        while address is not None:
            address = self.step(by_address[address])
            steps += 1
        return steps

    def step(self, i):
        from capstone import x86

        name, o = i.mnemonic, i.operands
        following = i.address + i.size
        if name == "ret":
            return None
        if name in ("nop", "vzeroupper"):
            return following
        if name == "test":
            self.sign = self.gpr["r8"] <= 0
            return following
        if name == "jle":
            return o[0].imm if self.sign else following
        if name == "jne":
            return following if self.zero else o[0].imm
        if name == "lea":
            self.gpr[i.reg_name(o[0].reg)] = self.address(i, o[1])
            return following
        if name == "add":
            self.gpr[i.reg_name(o[0].reg)] += o[1].imm
            return following
        if name == "dec":
            self.gpr[i.reg_name(o[0].reg)] -= 1
            self.zero = self.gpr[i.reg_name(o[0].reg)] == 0
            return following
        if name == "xor":
            assert i.reg_name(o[0].reg) == "r10d"
            self.gpr["r10"] = 0 if o[1].type == x86.X86_OP_REG else self.gpr["r10"] ^ o[1].imm
            self.zero = self.gpr["r10"] == 0
            return following
        self.operate(i, name, o)
        return following

    def operate(self, i, name, o):
        from capstone import x86

        if name == "vmovupd" and o[0].type == x86.X86_OP_MEM:
            words, k = self.locate(self.address(i, o[0]), self.lanes)
            words[k : k + self.lanes] = self.value(i, o[1])
            return
        name, o, predicate = plain(i, list(o))
        if name == "vcmppd":
            a, b = (self.value(i, x).view(np.float64) for x in o[1:3])
            chosen = a < b if predicate == 0x11 else a <= b
            if i.reg_name(o[0].reg) == "k1":
                self.mask = chosen
                return
            result = np.where(chosen, np.uint64(0xFFFFFFFFFFFFFFFF), np.uint64(0))
        elif name == "vpmovm2q":
            result = np.where(self.mask, np.uint64(0xFFFFFFFFFFFFFFFF), np.uint64(0))
        elif name == "vpternlogq":
            a, b, c = (self.value(i, x) for x in o[:3])
            table, result = o[3].imm & 0xFF, np.zeros_like(a)
            for row in range(8):
                if table >> row & 1:
                    result |= (a if row & 4 else ~a) & (b if row & 2 else ~b) & (c if row & 1 else ~c)
        elif name == "vblendvpd":
            a, b, m = (self.value(i, x) for x in o[1:4])
            result = np.where(m >> np.uint64(63) != 0, b, a)
        elif name in ("vpsllq", "vpsrlq"):
            shift = np.uint64(o[2].imm)
            a = self.value(i, o[1])
            result = a << shift if name == "vpsllq" else a >> shift
        elif name.startswith("vf"):
            form = name[-5:-2]
            x1, x2, x3 = (self.value(i, x).view(np.float64) for x in o[:3])
            a, b, c = {"132": (x1, x3, x2), "213": (x2, x1, x3), "231": (x2, x3, x1)}[form]
            if name.startswith("vfnmadd"):
                a = -a
            if name.startswith("vfmsub"):
                c = -c
            result = fma(a, b, c).view(np.uint64)
        else:
            sources = [self.value(i, x) for x in o[1:] if x.type != x86.X86_OP_IMM]
            floats = [s.view(np.float64) for s in sources]
            binary = {"vaddpd": np.add, "vsubpd": np.subtract, "vmulpd": np.multiply, "vdivpd": np.divide}
            bitwise = {
                "vandpd": np.bitwise_and,
                "vorpd": np.bitwise_or,
                "vxorpd": np.bitwise_xor,
                "vpaddq": np.add,
                "vpsubq": np.subtract,
            }
            if name in binary:
                result = binary[name](*floats).view(np.uint64)
            elif name in bitwise:
                result = bitwise[name](*sources)
            elif name == "vandnpd":
                result = ~sources[0] & sources[1]
            elif name == "vminpd":
                result = np.where(floats[0] < floats[1], sources[0], sources[1])
            elif name == "vmaxpd":
                result = np.where(floats[0] > floats[1], sources[0], sources[1])
            elif name == "vsqrtpd":
                result = np.sqrt(floats[0]).view(np.uint64)
            elif name in ("vrndscalepd", "vroundpd"):
                assert o[-1].imm & 0xFF == 8
                result = np.rint(floats[0]).view(np.uint64)
            elif name in ("vmovupd", "vmovapd", "vbroadcastsd"):
                result = sources[0]
            else:
                raise AssertionError(f"unexpected instruction {name} {i.op_str}")
        self.vector[self.number(i.reg_name(o[0].reg))] = result.astype(np.uint64)


@pytest.mark.parametrize("wide", [False, True], ids=["avx2", "avx512"])
def test_kernels_give_the_bits_of_the_interpreter(dump, wide):
    kernels = [k for k in dump["kernels"] if k["wide"] == wide]
    assert len(kernels) >= 10
    for kernel in kernels:
        machine = Machine(kernel)
        with np.errstate(all="ignore"):
            machine.run()
        result = machine.memory[0x40000000]
        expected = np.array(kernel["expected"], dtype=np.uint64)
        nan = np.isnan(expected.view(np.float64)) & np.isnan(result.view(np.float64))
        different = (result != expected) & ~nan
        assert not different.any(), (kernel["name"], int(different.sum()))
        assert math.isfinite(float(np.nansum(result.view(np.float64)))) or nan.any()


@pytest.fixture(scope="module")
def aarch64_instructions(tmp_path_factory):
    text = written(tmp_path_factory, "STARK_AARCH64_DUMP", "aarch64: instruction forms")
    return [line.split("\t") for line in text.splitlines()]


def test_every_instruction_form_of_aarch64(aarch64_instructions):
    assert len(aarch64_instructions) > 30_000
    md = capstone.Cs(capstone.CS_ARCH_ARM64, capstone.CS_MODE_ARM)
    code = bytes.fromhex("".join(words for _, words in aarch64_instructions))
    decoded = md.disasm_lite(code, 0)
    for expected, words in aarch64_instructions:
        _, _, name, operands = next(decoded, (0, 0, "nothing", ""))
        assert f"{name} {operands}" == as_capstone_writes(expected), words


def as_capstone_writes(text):
    name, operands = text.split(" ", 1)
    if name in ("ldr", "str"):
        register, base, offset = operands.split(" ")
        place = f"[{base}]" if offset == "0" else f"[{base}, #{number(int(offset))}]"
        return f"{name} {register} {place}"
    if name in ("shl", "ushr"):
        *registers, count = operands.split(", ")
        return f"{name} {', '.join(registers)}, #{number(int(count[1:]))}"
    return text
