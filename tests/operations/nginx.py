#!/usr/bin/env python3
"""Behind nginx, which speaks TLS and puts the server under a path."""
import os, shutil, subprocess, tempfile
from support import ROOT, Server, Viewer, check, finish, free_port, http, program, until

CONFIG = '''
daemon off; master_process off; pid {folder}/pid; error_log {folder}/error.log;
events {{}}
http {{
    access_log off;
    client_body_temp_path {folder}/a; proxy_temp_path {folder}/b; fastcgi_temp_path {folder}/c; uwsgi_temp_path {folder}/d; scgi_temp_path {folder}/e;
    map $http_upgrade $connection_upgrade {{ default upgrade; '' close; }}
    server {{
        listen 127.0.0.1:{port} ssl;
        ssl_certificate {folder}/cert.pem; ssl_certificate_key {folder}/key.pem;
        location /view/ {{
            proxy_pass http://127.0.0.1:{server}/;
            proxy_http_version 1.1;
            proxy_set_header Upgrade $http_upgrade;
            proxy_set_header Connection $connection_upgrade;
            proxy_buffering off;
            proxy_read_timeout 60s;
        }}
    }}
}}
'''


def main():
    nginx, openssl = program('nginx'), program('openssl')
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([openssl, 'req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:P-256', '-nodes', '-days', '2', '-subj',
                        '/CN=localhost', '-keyout', folder + '/key.pem', '-out', folder + '/cert.pem'], check=True, capture_output=True)
        server = Server('--allow-origin', 'https://render.example.org')
        port = free_port()
        with open(folder + '/nginx.conf', 'w') as f:
            f.write(CONFIG.format(folder=folder, port=port, server=server.port))
        proxy = subprocess.Popen([nginx, '-c', folder + '/nginx.conf', '-p', folder, '-e', folder + '/error.log'], stderr=subprocess.DEVNULL)
        try:
            page = until(lambda: answer(port, '/view/'), 10)
            check('https through nginx, under /view/: the page', page and page[0] == 200 and 'hello' in page[2])
            check('... /view/readyz', http(port, '/view/readyz', scheme='https')[2] == '{"ready":true}\n')
            origin = ['Origin: https://render.example.org']
            viewer = Viewer(port, 'https', '/view/ws', origin)
            for i in range(2, 22):
                viewer.camera(i)
            viewer.read(20, lambda: viewer.inputs and viewer.inputs[-1] == 21)
            check('... a viewer sees its last input', viewer.inputs and viewer.inputs[-1] == 21, viewer.inputs[-1:])
            check('... a page of another origin is refused', Viewer(port, 'https', '/view/ws', ['Origin: https://evil.example']).status == 403)
            server.process.terminate()
            viewer.read(5)
            check('... SIGTERM reaches the viewer: notice and 1001',
                  viewer.closed == 1001 and any('endsInMs' in t for t in viewer.texts), viewer.closed)
            check('... exit code 0', server.end()[0] == 0)
            in_browser(port, server.port)
        finally:
            proxy.terminate()
            proxy.wait()


def in_browser(port, behind):
    """The real page, where it was built and a browser is here."""
    client, node = ROOT + '/client-web/dist', shutil.which('node')
    chromium = os.environ.get('HELIOGRAPH_CHROMIUM', '/usr/bin/chromium')
    if not (node and os.path.exists(client + '/index.html') and os.path.exists(ROOT + '/client-web/node_modules') and os.path.exists(chromium)):
        print('not run: the page in a browser (npm run build in client-web, chromium)')
        return
    server = Server('--allow-origin', 'https://127.0.0.1:%d' % port, port=behind, client=client)
    seen = subprocess.run([node, ROOT + '/tests/browser/proxied.mjs', 'https://127.0.0.1:%d/view/' % port], capture_output=True, text=True, timeout=120)
    check('... the page in a browser: loads, opens its WebSocket, draws a frame', seen.returncode == 0,
          '' if seen.returncode == 0 else seen.stdout + seen.stderr)
    server.end()


def answer(port, path):
    try:
        return http(port, path, scheme='https')
    except OSError:
        return None


if __name__ == '__main__':
    main()
    finish()
