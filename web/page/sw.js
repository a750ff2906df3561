// Keeps the page for when there is no network. VERSION and FILES are filled in by scripts/web.sh.
const VERSION = 'VERSION_OF_FILES';
const FILES = LIST_OF_FILES;

addEventListener('install', event => {
  event.waitUntil(caches.open(VERSION).then(cache => cache.addAll(FILES)).then(() => skipWaiting()));
});

addEventListener('activate', event => {
  const old = names => names.filter(name => name !== VERSION).map(name => caches.delete(name));
  event.waitUntil(caches.keys().then(names => Promise.all(old(names))).then(() => clients.claim()));
});

addEventListener('fetch', event => {
  const kept = caches.match(event.request, { ignoreSearch: true });
  event.respondWith(kept.then(answer => answer ?? fetch(event.request)));
});
