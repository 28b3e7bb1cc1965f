"""Decimation in stages: what is left after one is compacted for the next."""
from __future__ import annotations
from typing import Any, NamedTuple
import os
import numpy as np
from gamutcore.decimation.collapse import collapse_all
from gamutcore.decimation.record import Record, empty_record
from gamutcore.decimation.samples import Deviation, deviation_on, no_deviation
from gamutcore.decimation.memoryless import Memoryless
from gamutcore.decimation.star import Surface, surface_of

class Part(NamedTuple):
    cost: Any
    surface: Any
    delivered: Any
    vertices: Any
    faces: Any

def carried(state, vertices, faces):
    if isinstance(state, Deviation):
        return deviation_on(state, faces) if state.counts[2] else no_deviation(len(state.pair), len(faces))
    if isinstance(state, Memoryless):
        return state._replace(sums=state.sums[vertices].copy(), fresh=state.fresh[vertices].copy(), area_vector=state.area_vector[faces].copy())
    if hasattr(state, '_replace'):
        return type(state)(*(carried(f, vertices, faces) if hasattr(f,'_fields') else f for f in state))
    return state

def copied(x):
    return type(x)(*(copied(f) if hasattr(f,'_fields') else f.copy() for f in x))

def compacted(part):
    s = part.surface
    corners = s.corner_facing[s.corner_facing >= 0]
    faces = np.unique(np.concatenate([corners, s.opposite[corners]]) // 3)
    ids = s.vertex.reshape(-1, 3)[faces]
    vertices, small = np.unique(ids, return_inverse=True)
    small = np.ascontiguousarray(small.reshape(-1, 3), np.int32)
    face_of = np.full(len(s.vertex)//3, -1, np.int32); face_of[faces] = np.arange(len(faces), dtype=np.int32)
    opp = s.opposite.reshape(-1,3)[faces].ravel()
    opp = np.ascontiguousarray(3*face_of[opp//3] + opp % 3, np.int32)
    surf = surface_of(np.ascontiguousarray(s.position[vertices]), small, opp)
    surf.deficit[0] = s.deficit[0]
    return Part(carried(part.cost, vertices, faces), surf, np.ascontiguousarray(part.delivered[vertices]), part.vertices[vertices], part.faces[faces])

def run(part, centre, step, down_to, way=(0, 0.), sweeping=False, done=None):
    rec = empty_record(len(part.delivered))
    n, rec = collapse_all(part.cost, part.surface, part.delivered, centre, step, rec, np.zeros(1, np.int64) if done is None else done,
        np.array(way, float), down_to, sweeping)
    return n, rec

def translated(record, part, n):
    v = part.vertices; f = part.faces
    c = lambda x: (3*f[x//3] + x % 3).astype(np.int32)
    return record._replace(kept=v[record.kept[:n]], dead=v[record.dead[:n]], position=record.position[:n], sides=v[record.sides[:n]],
        corner=c(record.corner[:n]), moved_end=record.moved_end[:n], moved=c(record.moved), shifted_end=record.shifted_end[:n], shifted=v[record.shifted])

def joined(records):
    cat = np.concatenate
    def ends(name):
        out, at = [], 0
        for r in records:
            e = getattr(r, name) + at
            out.append(e)
            at = e[-1] if len(e) else at
        return cat(out)
    d = {k: cat([getattr(r, k) for r in records]) for k in Record._fields if not k.endswith('_end')}
    d['moved_end'] = ends('moved_end'); d['shifted_end'] = ends('shifted_end')
    return Record(**d)

def put_back(big, part):
    big.surface.vertex.reshape(-1,3)[part.faces] = part.vertices[part.surface.vertex.reshape(-1,3)]
    big.delivered[part.vertices] = part.delivered
