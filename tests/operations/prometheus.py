#!/usr/bin/env python3
"""A real Prometheus scrapes a server that asks for a token, and answers every query of the dashboard."""
import json, os, subprocess, threading, time, urllib.parse
from support import ROOT, Server, Viewer, check, finish, free_port, http, program, until

TOKEN = 'a secret of this test 0123456789'


def query(port, expression):
    status, _, body = http(port, '/api/v1/query?query=' + urllib.parse.quote(expression))
    return json.loads(body) if status == 200 else {'status': 'error', 'error': body}


def looking(server, over):
    """A viewer who moves all the time."""
    viewer = Viewer(server.port, headers=['Authorization: Bearer ' + TOKEN])
    for i in range(2, 10 ** 6):
        if over.is_set():
            return
        viewer.camera(i)
        viewer.read(0.1)


def lint(text):
    result = subprocess.run([program('promtool'), 'check', 'metrics'], input=text, capture_output=True, text=True)
    check('promtool finds nothing in /metrics', result.returncode == 0 and not result.stderr.strip(), result.stderr.strip()[:300])


def main():
    prometheus = program('prometheus')
    folder = os.path.join(ROOT, 'out/operations')
    os.makedirs(folder, exist_ok=True)
    token_file = os.path.join(folder, 'token')
    with open(token_file, 'w') as f:
        f.write(TOKEN + '\n')
    os.chmod(token_file, 0o600)
    server = Server('--token-file', token_file)
    check('/metrics without the token: 401', server.get('/metrics')[0] == 401)
    status, fields, text = server.get('/metrics', ['Authorization: Bearer ' + TOKEN])
    check('/metrics with it: 200, text 0.0.4', status == 200 and 'version=0.0.4' in fields['content-type'])
    lint(text)
    port = free_port()
    config = os.path.join(server.folder.name, 'prometheus.yml')
    with open(config, 'w') as f:
        json.dump({'global': {'scrape_interval': '1s', 'scrape_timeout': '1s'},
                   'scrape_configs': [{'job_name': 'heliograph', 'authorization': {'credentials_file': token_file},
                                       'static_configs': [{'targets': ['127.0.0.1:%d' % server.port]}]}]}, f)
    scraper = subprocess.Popen([prometheus, '--config.file', config, '--storage.tsdb.path', os.path.join(server.folder.name, 'tsdb'),
                                '--web.listen-address', '127.0.0.1:%d' % port], stdout=subprocess.DEVNULL,
                               stderr=open(os.path.join(server.folder.name, 'prometheus.log'), 'w'))
    over = threading.Event()
    viewer = threading.Thread(target=looking, args=(server, over))
    viewer.start()
    try:
        up = until(lambda: _up(port), 60)
        check('Prometheus %s scrapes the server' % subprocess.run([prometheus, '--version'], capture_output=True, text=True).stdout.split()[2], bool(up))
        time.sleep(5)
        with open(os.path.join(ROOT, 'docs/reference/dashboard.json')) as f:
            panels = json.load(f)['panels']
        for panel in panels:
            for target in panel['targets']:
                answer = query(port, target['expr'])
                result = answer.get('data', {}).get('result', [])
                # A device that was never set aside still has its 0; nothing may be without a series.
                good = answer['status'] == 'success' and result and all(v['value'][1] not in ('+Inf', '-Inf') for v in result)
                shown = ', '.join('%s %s' % ('/'.join(v for k, v in r['metric'].items() if k not in ('instance', 'job', '__name__')), r['value'][1][:7])
                                  for r in result[:3])
                check('%s: %s' % (panel['title'], target['expr'][:90]), good, answer.get('error', shown))
        rate = query(port, 'sum(rate(heliograph_frames_sent_total[30s]))')['data']['result']
        check('frames are counted', rate and float(rate[0]['value'][1]) > 0, rate[0]['value'][1] if rate else '')
    finally:
        over.set()
        viewer.join()
        scraper.terminate()
        scraper.wait()
        server.end()


def _up(port):
    try:
        result = query(port, 'up{job="heliograph"}')['data']['result']
        return bool(result) and result[0]['value'][1] == '1'
    except (OSError, KeyError, ValueError, IndexError):
        return False


if __name__ == '__main__':
    main()
    finish()
