"""Passes of Blender, and the layers of Vellus that fill them."""

import json
import zlib
from dataclasses import dataclass

LOBES = ("R", "TT", "TRT", "TTs", "TRTs", "rest")


@dataclass(frozen=True)
class Pass:
    """A pass: its name in Blender, its channels, their letters and their kind, and the layer that fills it."""

    name: str
    channels: int
    letters: str
    kind: str
    layer: str


def passes_of(view_layer):
    """The passes that a view layer asks for, after Combined."""
    own = view_layer.vellus
    out = []
    if view_layer.use_pass_z:
        out.append(Pass("Depth", 1, "Z", "VALUE", "depth"))
    if view_layer.use_pass_normal:
        out.append(Pass("Normal", 3, "XYZ", "VECTOR", "normal"))
    if own.use_pass_albedo:
        out.append(Pass("Albedo", 3, "RGB", "COLOR", "albedo"))
    if own.use_pass_lobes:
        out += [Pass(f"Lobe {lobe}", 3, "RGB", "COLOR", f"lobes.{lobe}") for lobe in LOBES]
    for group in view_layer.lightgroups:
        out.append(Pass(f"Combined_{group.name}", 3, "RGB", "COLOR", f"lights.{group.name}"))
    levels = (view_layer.pass_cryptomatte_depth + 1) // 2
    for name, used, layer in (
        ("CryptoObject", view_layer.use_pass_cryptomatte_object, "crypto-object"),
        ("CryptoMaterial", view_layer.use_pass_cryptomatte_material, "crypto-look"),
    ):
        if used:
            out += [Pass(f"{name}{i:02}", 4, "RGBA", "COLOR", f"{layer}.{i}") for i in range(levels)]
    return out


UNSUPPORTED = (
    "vector position uv mist object_index material_index shadow ambient_occlusion emit environment diffuse_direct "
    "diffuse_indirect diffuse_color glossy_direct glossy_indirect glossy_color transmission_direct "
    "transmission_indirect transmission_color subsurface_direct subsurface_indirect subsurface_color "
    "cryptomatte_asset"
).split()


def unsupported(view_layer):
    """The names of passes that are switched on but not supported."""
    return [name for name in UNSUPPORTED if getattr(view_layer, f"use_pass_{name}", False)]


def layers_of(passes):
    """The names of Vellus' layers that fill these passes, without those that every picture has."""
    return sorted({p.layer.split(".")[0] for p in passes})


def cryptomatte_fields(picture, passes, layer_name):
    """Fields of a file's header that name the ids in the Cryptomatte passes: pairs of a field and a text."""
    out = []
    for p in passes:
        layer, _, level = p.layer.partition(".")
        if layer.startswith("crypto-") and int(level) == 0:
            title = f"{layer_name}.{p.name[:-2]}"
            ids = {name: f"{value:08x}" for name, value in picture.ids(layer).items()}
            # The key need only differ between the layers of a file.
            key = f"cryptomatte/{zlib.crc32(title.encode()):08x}"[:-1]
            out += [
                (f"{key}/name", title),
                (f"{key}/hash", "MurmurHash3_32"),
                (f"{key}/conversion", "uint32_to_float32"),
                (f"{key}/manifest", json.dumps(ids, ensure_ascii=False)),
            ]
    return out
