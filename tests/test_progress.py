from ifs_cad import progress


def test_reports_reach_the_innermost_listener_only():
    outer, inner = [], []
    with progress.listening(lambda *report: outer.append(report)):
        progress.report("panels", 1, 4)
        with progress.listening(lambda *report: inner.append(report)):
            progress.report("panels", 2, 4)
        progress.report("writing")
    progress.report("nobody hears this")
    assert outer == [("panels", 1, 4), ("writing", 0, None)]
    assert inner == [("panels", 2, 4)]
