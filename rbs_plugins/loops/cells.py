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


def survey(begin, end, thread, bits, steps, masks, alive, failed, margin, last, width, chunk):
    """Says for each range and step whether any bond holds, ahead or back; forgets which steps have failed."""
    for c in range(begin, end):
        a = margin + c * chunk
        e = min(a + chunk, last)
        for k in range(steps.size):
            failed[c, k] = 0
            word, s, mask = k // width, steps[k], masks[k]
            ahead, back = bits[word, a:e], bits[word, a - s : e - s]
            some = ahead[0] & mask
            for q in range(ahead.size):
                some = some | ((ahead[q] | back[q]) & mask)
            alive[c, k] = some != 0
    return 0


def broken_share(begin, end, thread, present, bits, steps, masks, volume, cells, first, out, margin, width, chunk):
    """Damage: out = 1 - sum of the intact neighbor volumes over the sum of all; volume by cell."""
    for c in range(begin, end):
        for i in range(first[c], first[c + 1]):
            cell = cells[i]
            total, left = 0.0, 0.0
            for k in range(steps.size):
                word, s, mask = k // width, steps[k], masks[k]
                for side in range(2):
                    here = cell - side * s
                    there = cell - s if side == 1 else cell + s
                    if present[word, here] & mask != 0:
                        total += volume[there]
                        left += volume[there] if bits[word, here] & mask != 0 else 0.0
            out[i] = 1.0 - left / total if total > 0 else 0.0
    return 0
