"""Small loops over the cells of a lattice that no law takes part in: copying to cells, looking for bonds, damage."""

from __future__ import annotations


def gather(begin, end, thread, source, target, cells, first, moved):
    """Copies rows (n, d) of nodes to cells (d, size), and says for each range whether anything is not zero."""
    for c in range(begin, end):
        some = False
        for k in range(target.shape[0]):
            row = target[k]
            for i in range(first[c], first[c + 1]):
                value = source[i, k]
                row[cells[i]] = value
                some = some | (value != 0)
        moved[c] = some
    return 0


def gather_dense(begin, end, thread, source, target, first, moved, margin):
    """The same where every cell holds a node."""
    for c in range(begin, end):
        rows = source[first[c] : first[c + 1]]
        some = False
        for k in range(target.shape[0]):
            row = target[k, first[c] + margin : first[c + 1] + margin]
            for q in range(row.size):
                value = rows[q, k]
                row[q] = value
                some = some | (value != 0)
        moved[c] = some
    return 0


def carry(begin, end, thread, source, target, cells):
    """Copies values (n,) of nodes to their cells."""
    for i in range(begin, end):
        target[cells[i]] = source[i]
    return 0


HOLDS, MAY_FAIL = 1, 2


def survey(begin, end, thread, bits, zone, steps, masks, alive, failed, margin, last, width, chunk):
    """Says for each range and step whether any bond holds, and may fail, ahead or back; forgets which have failed."""
    for c in range(begin, end):
        a = margin + c * chunk
        e = min(a + chunk, last)
        for k in range(steps.size):
            failed[c, k] = 0
            word, s, mask = k // width, steps[k], masks[k]
            ahead, back = bits[word, a:e], bits[word, a - s : e - s]
            zone_ahead, zone_back = zone[word, a:e], zone[word, a - s : e - s]
            some = ahead[0] & mask
            weak = some & zone_ahead[0]
            for q in range(ahead.size):
                some = some | ((ahead[q] | back[q]) & mask)
                weak = weak | (((ahead[q] & zone_ahead[q]) | (back[q] & zone_back[q])) & mask)
            alive[c, k] = HOLDS * (some != 0) + MAY_FAIL * (weak != 0)
    return 0


def count_volumes(total, left, there_ahead, there_back, holds_ahead, holds_back, volume_ahead, volume_back, mask):
    """Adds the volumes of the neighbors ahead and back of a step, and of those whose bonds hold."""
    for q in range(total.size):
        v, w = volume_ahead[q], volume_back[q]
        total[q] += (v if there_ahead[q] & mask != 0 else 0.0) + (w if there_back[q] & mask != 0 else 0.0)
        left[q] += (v if holds_ahead[q] & mask != 0 else 0.0) + (w if holds_back[q] & mask != 0 else 0.0)


def broken_share(
    begin, end, thread, present, bits, steps, masks, volume, cells, first, out, scratch, margin, last, width, chunk
):
    """Damage: out = 1 - sum of the intact neighbor volumes over the sum of all; volume by cell."""
    for c in range(begin, end):
        a = margin + c * chunk
        e = min(a + chunk, last)
        total, left = scratch[thread, 0, : e - a], scratch[thread, 1, : e - a]
        total[:] = 0.0
        left[:] = 0.0
        for k in range(steps.size):
            word, s = k // width, steps[k]
            there, holds = present[word], bits[word]
            count_volumes(
                total, left, there[a:e], there[a - s : e - s], holds[a:e], holds[a - s : e - s],
                volume[a + s : e + s], volume[a - s : e - s], masks[k],
            )  # fmt: skip
        for i in range(first[c], first[c + 1]):
            q = cells[i] - a
            out[i] = 1.0 - left[q] / total[q] if total[q] > 0 else 0.0
    return 0
